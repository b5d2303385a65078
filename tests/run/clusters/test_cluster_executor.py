"""Executors on clusters check their config before anything is learned."""

from __future__ import annotations

import os
import sys
from unittest.mock import patch

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.run.clusters import cluster_executor
from rl_design_space.run.clusters.cluster_executor import ClusterExecutor
from rl_design_space.run.clusters.dask import DaskExecutor
from rl_design_space.run.clusters.ray import RayExecutor

pytestmark = pytest.mark.parametrize("executor", [DaskExecutor, RayExecutor])


@pytest.fixture(autouse=True)
def _variables():
    """Forget the variables that executors set."""
    with patch.dict(os.environ):
        yield


@pytest.mark.parametrize(
    ("address", "chunk", "message"),
    [
        (None, 0, "hydra.launcher.chunk=0: should be null or a whole number of at least 1"),
        ("here", None, "hydra.launcher.address=here: should be null or like "),
        ("127.0.0.1:9", None, "hydra.launcher.address=127.0.0.1:9: no cluster can be reached there: "),
    ],
)
def test_an_invalid_value_is_refused(
    executor: type[ClusterExecutor], address, chunk, message: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(cluster_executor, "import_module", lambda name: None)
    with pytest.raises(ConfigError) as caught:
        executor(address, chunk, 2)
    assert str(caught.value).startswith(message)


def test_a_missing_extra_is_named(executor: type[ClusterExecutor], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, executor.module, None)
    with pytest.raises(ConfigError) as caught:
        executor(None, None, 2)
    extra = executor.extra
    assert str(caught.value) == (
        f"hydra/launcher=design_{extra}: needs {extra.capitalize()}; pip install 'rl-design-space[{extra}]'"
    )
