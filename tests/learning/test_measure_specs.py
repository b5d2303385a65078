"""Measures by their specification: as text, and as a mapping in YAML."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rl_design_space.analysis.statistics import resample_weights
from rl_design_space.design import DesignPoint, NewGoals, Task
from rl_design_space.errors import ConfigError
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.learning.measures import MEASURES, canonical, forms, measure
from tests.analysis.made_up import TRIALS, MadeUp

#: 200 steps in trials 0 to 4, then 12, where 10 is the optimum.
PLAIN = MadeUp(last=12.0, first=200.0, until=5, noise=0.0)


def value(spec: Any, recorded: MadeUp | LearningCurves = PLAIN) -> float:
    count = len(recorded.steps)
    return float(measure(spec).samples(recorded, np.full((1, count), 1 / count))[0])


@pytest.mark.parametrize(
    ("spec", "text"),
    [
        ("total_steps", "total_steps"),
        ("total_steps,statistic=mean", "total_steps"),
        ("final_over_optimum", "final_over_optimum"),
        ("steps_after", "steps_after=30"),
        (" steps_after=30.0 ", "steps_after=30"),
        ({"steps_after": 7}, "steps_after=7"),
        ({"gap_closed": 0.90}, "gap_closed=0.9"),
        ({"trials_to": 1}, "trials_to=1"),
        ({"statistic": "median", "steps_after": 30}, "steps_after=30,statistic=median"),
        ("steps_after=30, statistic=cvar=5", "steps_after=30,statistic=cvar=5"),
        ({"total_steps": None, "statistic": {"cvar": 1}}, "total_steps,statistic=cvar=1"),
        ({"_target_": "mine.late", "b": True, "a": 0.5}, "mine.late,a=0.5,b=true"),
        ("mine.late,b=true,a=0.5", "mine.late,a=0.5,b=true"),
        ({"_target_": "mine.late", "statistic": "median"}, "mine.late,statistic=median"),
        ({"solved": None, "stage": "last"}, "solved,stage=last"),
        ({"solved_within": None, "stage": 2, "statistic": "median"}, "solved_within=2,stage=2,statistic=median"),
    ],
)
def test_each_way_to_write_a_measure_has_one_text_form(spec: Any, text: str):
    assert canonical(spec) == text
    assert canonical(text) == text


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("steps_after=3", 2 * 200 + 15 * 12),
        ("steps_after=0", 5 * 200 + 15 * 12),
        ("gap_closed=0.9", 5),
        ("gap_closed=1", TRIALS),  # the curve ends at 1.2
        ("gap_left", 0.2 / 19),
        ("trials_to=1.25", 5),
        ("trials_to=1.1", TRIALS),
        ("trials_to=20", 0),
        ("near_share=1.25", 1),
        ("near_share=1.1", 0),
        ("solved", 1),
        ("solved_within=2", 0.75),
        ("solved_within=1.1", 0),
        ("total_steps,stage=last", 5 * 200 + 15 * 12),  # without stages there is one
        ("steps_after=3,stage=1", 2 * 200 + 15 * 12),
        ("total_steps,statistic=median", 5 * 200 + 15 * 12),
    ],
)
def test_families_by_hand(spec: str, expected: float):
    assert value(spec) == pytest.approx(expected)


def test_a_first_trial_is_censored_at_the_number_of_trials():
    assert {name: measure(name).censored_at(PLAIN) for name in forms()} == {
        name: float(TRIALS) if name.startswith(("trials_to", "gap_closed")) else None for name in forms()
    }


def test_a_gap_of_nothing_has_no_share_that_is_left():
    assert np.isnan(value("gap_left", MadeUp(first=10.0, last=10.0, noise=0.0)))


class Erratic(MadeUp):
    """A fifth of the periods never learns."""

    @property
    def steps(self) -> np.ndarray:
        steps = super().steps
        steps[::5] = 1000
        return steps


def test_robust_companions_of_a_heavy_tail():
    of = Erratic(last=12.0, first=200.0, until=5, noise=0.0)
    usual = 5 * 200 + 15 * 12
    assert value("total_steps", of) == pytest.approx(0.8 * usual + 0.2 * 20_000)
    assert value("total_steps,statistic=median", of) == usual
    assert value("total_steps,statistic=iqm", of) == usual
    assert value("total_steps,statistic=cvar=5", of) == 20_000
    assert value("trials_to=1.25", of) == TRIALS
    assert value("trials_to=1.25,statistic=median", of) == 5
    assert value("gap_left,statistic=median", of) == pytest.approx(0.2 / 19)


@pytest.mark.parametrize(
    "spec", [*MEASURES, "steps_after=3", "gap_closed=0.5", "trials_to=1.5,statistic=median", "near_share=1.2"]
)
def test_samples_of_all_are_one_number_for_each_resample(spec: str):
    found, weights = measure(spec), resample_weights(60, resamples=40)
    recorded = MadeUp(noise=0.3)
    samples = found.samples(recorded, weights)
    assert samples.shape == (40,)
    assert samples.min() - 1e-9 <= value(spec, recorded) <= samples.max() + 1e-9
    each = found.each(recorded)
    assert each is None or each.mean() == pytest.approx(value(spec, recorded))


def test_a_statistic_is_part_of_the_meaning():
    assert measure("total_steps").meaning == "steps of all trials of a period, mean over periods"
    assert measure("total_steps,statistic=cvar=1").meaning.endswith("mean over the worst 1 % of the periods")
    assert "the median curve" in measure("trials_to,statistic=median").meaning
    assert "a curve that ends worse is faster" in measure("trials_to_final").meaning
    assert not any("{" in meaning for meaning in forms().values())


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("totl_steps", "totl_steps: no such measure; did you mean total_steps?"),
        ("steps_after=-1", "steps_after=-1: should be a trial, a whole number from 0"),
        ({"steps_after": 1.5}, "steps_after=1.5: should be a trial"),
        ({"steps_after": True}, "steps_after=true: should be a trial"),
        ({"steps_after": float("inf")}, "steps_after=inf: should be a trial"),
        ("gap_closed=0", "gap_closed=0: should be a share above 0, up to 1"),
        ("trials_to=0.9", "trials_to=0.9: should be a factor of at least 1"),
        ("near_share=x", "near_share=x: should be a factor of at least 1"),
        ("total_steps=3", "total_steps=3: takes no parameter"),
        ("total_steps,after=3", "measure total_steps: after: no such parameter"),
        ("total_steps,stage=0", "stage=0: should be the number of a stage, from 1, or last"),
        ("total_steps,stage=first", "stage=first: should be the number of a stage, from 1, or last"),
        ("total_steps,statistic=mode", "statistic=mode: should be among mean, median"),
        ("trials_to,statistic=iqm", "statistic=iqm: should be mean or median, for a measure of a curve"),
        ({"statistic": "median"}, "names a statistic but no measure"),
        ("", "measure=: should be a name"),
        ("total_steps=", "should be a name"),
        ({}, "should be a name, such as total_steps, or a mapping"),
        (3, "measure=3: should be a name"),
        ({"_target_": "mine.late", "a": [1]}, "a parameter should be a number, true, false, or text without commas"),
        ({"_target_": "mine.late", "a": "3"}, "a parameter should be a number, true, false, or text without commas"),
    ],
)
def test_what_is_wrong_is_named(spec: Any, message: str):
    with pytest.raises(ConfigError) as raised:
        canonical(spec)
    assert message in str(raised.value)


def test_steps_after_the_last_trial_are_refused_where_the_trials_are_known():
    with pytest.raises(ConfigError, match="steps_after=20: there are 20 trials; should be less"):
        value("steps_after=20")


def test_the_names_of_recorded_measures_stay():
    periods = {
        "late_steps",
        "failed_trials",
        "failed_periods",
        "final_failed",
        "not_near_optimum",
        "outliers",
        "solved",
    }
    totals = {"total_steps", "total_steps_scaled", "final_steps_over_optimum"}
    assert set(MEASURES) == {*totals, *periods, "trials_to_final", "trials_to_optimum", "gap_left", "roughness"}


def test_a_measure_of_a_stage_is_that_of_its_trials_alone():
    point = DesignPoint(task=Task(periods=6, trials=5, goals=1), curriculum=NewGoals(layouts=2, zero_shot=3))
    curves = simulate(point)
    assert value("total_steps,stage=2", curves) == pytest.approx(curves.steps[:, 5:8].sum(axis=1).mean())
    assert value("total_steps,stage=last", curves) == pytest.approx(curves.steps[:, 8:].sum(axis=1).mean())
    assert value("solved,stage=2,statistic=median", curves) == np.median(curves.success[:, 5:8].mean(axis=1))
    assert measure("trials_to=1.1,stage=2").censored_at(curves) == 3
    assert measure("solved,stage=2").meaning.startswith("share of trials that reach the final goal")
    with pytest.raises(ConfigError, match="stage=4: should be from 1 to 3, the stages of this point, or last"):
        value("total_steps,stage=4", curves)
