"""The objective of a point: a recorded scalar, or a measure that is computed from its result."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning import LearningCurves
from rl_design_space.run.objective import objective_value, recorded_result
from rl_design_space.tracking.tracker import StoredRun
from tests.tracking.stores import learned

PLANNED, CURVES = learned()


def nothing() -> LearningCurves:
    raise AssertionError("the result is not needed")


def test_a_scalar_is_taken_as_it_was_recorded():
    assert objective_value("total_steps", {"total_steps": 3.0}, nothing) == 3
    with pytest.raises(ConfigError, match=r"objective=total_steps_scaled: this point has no such scalar, only a"):
        objective_value("total_steps_scaled", {"a": 3.0}, nothing)


def test_a_measure_is_computed_from_the_result():
    expected = CURVES.steps[:, 2:].sum(axis=1).mean()
    assert objective_value("steps_after=2", {"total_steps": 3.0}, lambda: CURVES) == pytest.approx(expected)


def test_the_result_of_a_recorded_point_is_read():
    arrays = {name: getattr(CURVES, name) for name in ("steps", "success", "optimum", "rows", "epsilon")}
    reader = SimpleNamespace(periods=lambda run: arrays if run.run_id == "whole" else {"steps/mean": CURVES.epsilon})
    tracking = SimpleNamespace(reader=lambda: reader)
    found = recorded_result("gap_left", tracking, StoredRun("whole", artifacts="there"), PLANNED.point)
    assert (found.steps == CURVES.steps).all()
    assert found.side == 4
    with pytest.raises(ConfigError, match=r"objective=gap_left: run other kept its learning curves alone; needs"):
        recorded_result("gap_left", tracking, StoredRun("other", artifacts="there"), PLANNED.point)
    with pytest.raises(ConfigError, match=r"objective=gap_left: .* is not delivered yet; `rl-design-space sync`"):
        recorded_result("gap_left", tracking, StoredRun(), PLANNED.point)
