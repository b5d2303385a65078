"""Settings: where they write."""

from __future__ import annotations

from pathlib import Path

import pytest
from omegaconf import OmegaConf

from rl_design_space.plan.planner import Planner
from rl_design_space.run.settings import build_settings
from rl_design_space.tracking import MlflowTracking


def test_a_tilde_is_the_home_folder(planner: Planner, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HOME", "/home/ada")
    config = planner.composer.config(["outputs='~/x'"])
    settings = build_settings(config)
    assert settings.outputs == "/home/ada/x"
    assert isinstance(settings.tracking, MlflowTracking)
    assert settings.tracking.uri == "sqlite:////home/ada/x/mlflow.db"
    assert Path(settings.tracking.spool) == Path("/home/ada/x/spool")
    # Hydra creates these.
    assert {OmegaConf.select(config, f"hydra.{mode}.dir") for mode in ("run", "sweep")} == {"/home/ada/x"}
