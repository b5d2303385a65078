"""What all tests share."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from rl_design_space.plan.planner import Planner
from rl_design_space.tracking.connection import connect
from tests.order import LONGEST, Scheduling
from tests.points import planning
from tests.servers import (  # noqa: F401  (fixtures)
    _shared_mlflow_server,
    auth_server,
    idle_mlflow_server,
    mlflow_server,
    postgres,
)
from tests.tracking.stores import import_mlflow


@pytest.fixture(scope="module")
def planner() -> Iterator[Planner]:
    """One planner a module: composing takes Hydra 0.1 s, and what is composed once is kept."""
    with planning() as planner:
        yield planner


@pytest.fixture(scope="session")
def empty_database(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database as MLflow creates it, which takes seconds, so it is copied; it has no experiment of ours."""
    import_mlflow()
    database = tmp_path_factory.mktemp("empty") / "mlflow.db"
    connect(f"sqlite:///{database}")
    return database


# Half of what is usual; properties that need more say so.
settings.register_profile("suite", max_examples=50)
settings.load_profile("suite")


def pytest_configure(config: pytest.Config) -> None:
    """Keep the order of files, which pytest-xdist would change into that of their numbers of tests.

    Collect garbage more rarely: looking for it takes a twentieth of the time of tests, and a tenth of compiling.
    """
    gc.set_threshold(50_000, 20, 20)
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Scheduling | None:
    """Keep files whole in all runs with several processes, unless another way is asked for."""
    return Scheduling(config, log) if config.getvalue("dist") in {"load", "loadfile"} else None


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell each of several processes whether all tests are run."""
    config = node.config
    node.workerinput["whole"] = config.args_source is config.ArgsSource.TESTPATHS and not config.option.keyword


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernel, if all tests are run: each of several processes its part."""
    process: dict[str, Any] = getattr(session.config, "workerinput", {})
    if process.get("whole"):
        from tests.forms import compile_forms

        with suppress(Exception):  # tests will show it
            compile_forms(int(process["workerid"].removeprefix("gw")), process["workercount"])


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the longest files first."""
    tests = Path(__file__).parent
    ranks = {tests / name: rank for rank, name in enumerate(LONGEST)}
    items.sort(key=lambda item: ranks.get(item.path, len(LONGEST)))


def pytest_collection_finish() -> None:
    """Have no collection of garbage look at the tests and at what they import."""
    gc.collect()
    gc.freeze()


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """A test may skip where a service is missing on somebody's machine; in CI a skip is a failure."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") and reporter is not None and reporter.stats.get("skipped"):
        reporter.write_line("In CI nothing may be skipped.", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
