"""Hydra's tests of launchers, run on ours: for other applications, it is an ordinary launcher.

`BatchedSweeperTestSuite` cannot be run: the sweeper that it launches batches with is only in Hydra's repository.
`hydra/launcher=design_dask` and `design_ray` are not run: they inherit everything that is tested here.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from hydra.core.plugins import Plugins
from hydra.test_utils.launcher_common_tests import IntegrationTestSuite, LauncherTestSuite
from hydra.version import VersionBase
from packaging.version import Version

from rl_design_space._paths import CONF, make_plugins_known
from tests.command_runner import output_of

# The applications of the suites set no Hydra version, of which Hydra warns.
pytestmark = pytest.mark.filterwarnings("ignore:(?s).*Future Hydra versions will no longer change working directory")

#: These applications have their own config folders; `hydra/launcher/design.yaml` is in ours.
SEARCHPATH = f"hydra.searchpath=[file://{CONF}]"


@pytest.fixture(autouse=True)
def our_plugins(monkeypatch: pytest.MonkeyPatch, hydra_restore_singletons: None) -> None:
    """Register our plugins for one test, in this process and in those that it starts."""
    # The version that applications of the suites get by default, unless another test has set one.
    VersionBase.instance().setbase(Version("1.1"))
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setenv("PYTHONPATH", os.environ.get("PYTHONPATH", ""))
    make_plugins_known()
    # Hydra searches for plugins once per process, possibly before ours were registered.
    plugins = Plugins.instance()
    from hydra_plugins.rl_design_space.launcher import DesignLauncher

    plugins.register(DesignLauncher)


@pytest.mark.parametrize(("launcher_name", "overrides"), [("design", [SEARCHPATH])], ids=["design"])
class TestDesignLauncher(LauncherTestSuite):
    pass


@pytest.mark.parametrize(
    ("task_launcher_cfg", "extra_flags"), [({}, ["-m", SEARCHPATH, "hydra/launcher=design"])], ids=["design"]
)
class TestDesignLauncherIntegration(IntegrationTestSuite):
    pass


OLD_APPLICATION = """
import os
import hydra

@hydra.main(version_base="1.1", config_path=None)
def application(config):
    print("runs in", os.getcwd())

application()
"""


def test_an_application_with_an_earlier_hydra_version_runs_unchanged(tmp_path: Path):
    # Hydra 1.1 ran each job in its own folder.
    (tmp_path / "application.py").write_text(OLD_APPLICATION, encoding="utf-8")
    flags = ["-m", SEARCHPATH, "hydra/launcher=design", "hydra.sweep.dir=there"]
    written = output_of(sys.executable, "application.py", *flags, cwd=tmp_path)
    assert f"runs in {tmp_path}/there/0" in written.splitlines()
