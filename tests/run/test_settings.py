"""Settings: where they write."""

from __future__ import annotations

from pathlib import Path

import pytest
from omegaconf import OmegaConf

from rl_design_space.errors import ConfigError
from rl_design_space.plan.planner import Planner
from rl_design_space.run.settings import build_settings, settings_of
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


def test_measures_in_settings_are_named_by_their_text():
    own = "{_target_: no_such_module.late, share: 0.25}"
    words = ["objective={steps_after: 30, statistic: median}", f"tracking.leaderboard=[{own},{{trials_to: 1.2}}]"]
    settings = settings_of(words)
    assert settings.objective == "steps_after=30,statistic=median"
    assert settings.tracking.leaderboard == ("no_such_module.late,share=0.25", "trials_to=1.2")
    with pytest.raises(ConfigError, match=r"objective: final_step: no such measure; did you mean final_steps"):
        settings_of(["objective=final_step"])
