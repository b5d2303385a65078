"""Blocks at equal rows and at equal steps: the numbers of the study `refine`, with few periods."""

from __future__ import annotations

import numpy as np
import pytest

from rl_design_space.config.compose import shipped_config
from rl_design_space.learning import simulate
from rl_design_space.plan.study import load_study
from rl_design_space.report.base import MAIN
from rl_design_space.report.resolution import CURVES, EQUAL_ROWS
from rl_design_space.report.runs import Runs
from tests.report.readers import LearningReader


def test_the_numbers_are_those_of_the_periods():
    with shipped_config():
        study = load_study("refine", ["task.periods=8", "task.max_steps=500"])
        report = study.report()
    frames = report.frames(Runs.of_study(study, LearningReader(study.plan)))
    main, equal, curves = frames[MAIN], frames[EQUAL_ROWS], frames[CURVES]
    assert main["kind"].tolist() == ["uniform"] * 5 + ["adaptive"] * 4 + ["all split"]
    assert main["rows"].tolist()[:5] == [12, 30, 75, 150, 300]
    assert equal["budget"].tolist() == [30, 75, 150, 300]

    uniform, adaptive = (simulate(list(study.plan)[at].point) for at in (2, 6))
    ratio = equal.iloc[1]
    assert ratio["total_steps"] == pytest.approx(adaptive.total_steps.mean() / uniform.total_steps.mean())
    assert ratio["total_steps_low"] < ratio["total_steps"] < ratio["total_steps_high"]
    ended = (np.cumsum(uniform.steps, axis=1) <= 2500).sum(axis=1).mean()
    assert main["trials_in_2500"][2] == pytest.approx(ended)
    curve = curves[(curves["kind"] == "uniform") & (curves["rows"] == 75)]
    assert curve["before"].iloc[2] == pytest.approx(curve["steps"].iloc[:2].sum())
