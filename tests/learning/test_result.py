"""Results: scalars, curves, frames and files, by hand for two periods of three trials."""

from __future__ import annotations

import pickle
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rl_design_space.design import DesignPoint, Task, Torus
from rl_design_space.learning import LearningCurves, simulate
from rl_design_space.learning.archive import read_arrays
from rl_design_space.learning.measures import SCALARS
from rl_design_space.learning.result import Kept, read_saved
from tests.learning.strategies import results

CAP = 100


def curves_of(steps: list[list[int]], optimum: list[int], seconds: float = 0.5) -> LearningCurves:
    """Return a result with these steps; a trial at the cap has failed."""
    table = np.array(steps, dtype=np.int32)
    return LearningCurves(
        steps=table,
        success=table < CAP,
        optimum=np.array(optimum, dtype=np.int32),
        rows=np.ones((len(optimum), 2), dtype=np.int32),
        epsilon=np.linspace(0.9, 0.1, table.shape[1]),
        seconds=seconds,
    )


TWO_PERIODS = curves_of([[40, 20, 10], [CAP, 20, 5]], optimum=[10, 5])


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("total_steps", (70 + 125) / 2),
        # Two values a and b have the standard error |a - b| / 2.
        ("total_steps_sem", 27.5),
        ("total_steps_scaled", 97.5 * 10 / 20),
        ("failed_trials", 1 / 6),
        ("failed_periods", 1 / 2),
        # The last ten trials are all three of them: (4 + 2 + 1) / 3 and (20 + 4 + 1) / 3.
        ("final_steps_over_optimum", (7 / 3 + 25 / 3) / 2),
        ("env_steps_per_second", 195 / 0.5),
    ],
)
def test_scalars(name: str, expected: float):
    value = TWO_PERIODS.scalars((20, 20))[name]
    assert value == pytest.approx(expected)
    assert type(value) is float


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("steps/mean", [70, 20, 7.5]),
        ("steps/median", [70, 20, 7.5]),
        ("steps/q10", [46, 20, 5.5]),
        ("steps/q90", [94, 20, 9.5]),
        ("steps/over_optimum", [12, 3, 1]),
        ("success_rate", [0.5, 1, 1]),
        ("epsilon", [0.9, 0.5, 0.1]),
    ],
)
def test_curves(name: str, expected: list[float]):
    np.testing.assert_allclose(TWO_PERIODS.curves[name], expected)


def test_there_are_no_other_scalars_and_curves():
    assert set(TWO_PERIODS.curves) == {
        "steps/mean",
        "steps/median",
        "steps/q10",
        "steps/q90",
        "steps/over_optimum",
        "success_rate",
        "epsilon",
    }
    assert len(TWO_PERIODS.scalars((20, 20))) == 7


def test_failed_trials_count_at_the_cap():
    assert TWO_PERIODS.total_steps.tolist() == [70, CAP + 25]


def test_one_period_has_no_standard_error():
    scalars = curves_of([[40, 20, 10]], optimum=[10]).scalars((10, 10))
    assert "total_steps_sem" not in scalars
    assert scalars["total_steps"] == 70


def test_a_rectangle_has_no_scaled_steps():
    assert "total_steps_scaled" not in TWO_PERIODS.scalars((20, 10))


@pytest.mark.parametrize(("side", "expected"), [(10, 97.5), (20, 48.75), (30, 32.5)])
def test_table_4_is_divided_by_a_tenth_of_the_side(side: int, expected: float):
    assert TWO_PERIODS.scalars((side, side))["total_steps_scaled"] == pytest.approx(expected)


def test_the_final_policy_is_that_of_the_last_ten_trials():
    slow_then_optimal = curves_of([[90] * 5 + [4] * 10], optimum=[4])
    assert slow_then_optimal.scalars((10, 10))["final_steps_over_optimum"] == 1


def test_sums_of_long_periods_do_not_overflow():
    steps = np.full((2, 1000), 2**31 - 1, dtype=np.int32)
    curves = LearningCurves(steps, steps > 0, np.ones(2, np.int32), np.ones((2, 2), np.int32), np.zeros(1000), 1.0)
    assert curves.total_steps.tolist() == [1000 * (2.0**31 - 1)] * 2


def test_the_repr_fits_the_screen():
    assert repr(TWO_PERIODS) == (
        "LearningCurves of 2 periods × 3 trials\n"
        "  total steps   98 ± 28 (standard error) a period\n"
        "  success       83.33% of trials; every trial in 1 of 2 periods\n"
        "  final policy  5.33 × the optimum, last 3 trials\n"
        "  seconds       0.500"
    )


def test_the_repr_of_one_period_has_no_standard_error():
    assert repr(curves_of([[40, 20, 10]], optimum=[10])).splitlines()[1] == "  total steps   70 a period"


def test_a_frame_has_a_row_for_each_trial_and_a_column_for_each_curve():
    frame = TWO_PERIODS.to_frame()
    assert list(frame) == ["trial", *TWO_PERIODS.curves]
    assert frame["trial"].tolist() == [0, 1, 2]
    assert frame["steps/mean"].tolist() == [70, 20, 7.5]


def test_a_frame_of_periods_has_a_row_for_each_period_and_trial():
    frame = TWO_PERIODS.to_frame(periods=True)
    rows = frame.itertuples(index=False, name=None)
    assert list(frame) == ["period", "trial", "steps", "success", "optimum", "epsilon"]
    assert list(rows) == [
        (0, 0, 40, True, 10, 0.9),
        (0, 1, 20, True, 10, 0.5),
        (0, 2, 10, True, 10, 0.1),
        (1, 0, CAP, False, 5, 0.9),
        (1, 1, 20, True, 5, 0.5),
        (1, 2, 5, True, 5, 0.1),
    ]


def test_a_frame_is_a_copy():
    frame = TWO_PERIODS.to_frame(periods=True)
    frame["steps"] = 0
    frame.loc[:, "optimum"] = 0
    assert TWO_PERIODS.steps.sum() == 195
    assert TWO_PERIODS.optimum.tolist() == [10, 5]


def test_computing_curves_does_not_change_the_result():
    curves = curves_of([[40, 20, 10], [CAP, 20, 5]], optimum=[10, 5])
    twin = pickle.loads(pickle.dumps(curves))
    assert repr(twin) == repr(curves)
    assert curves != twin  # arrays make no truth value, so curves are equal only to themselves
    twin.to_frame()
    np.testing.assert_array_equal(twin.steps, curves.steps)


POINT = DesignPoint(task=Task(goals=1, periods=2, trials=3), world=Torus(size=20))


@settings(deadline=None)
@given(result=results(POINT), compress=st.booleans())
def test_a_saved_result_is_loaded_bit_by_bit(result: LearningCurves, compress: bool):
    file = BytesIO()
    result.save(file, compress=compress)
    again = LearningCurves.load(BytesIO(file.getvalue()), POINT, result.seconds)
    for name in ("steps", "success", "optimum", "rows", "epsilon"):
        one, other = getattr(again, name), getattr(result, name)
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    assert again.point is POINT
    assert again.scalars() == result.scalars()
    twin = BytesIO()
    again.save(twin, compress=compress)
    assert twin.getvalue() == file.getvalue()


@pytest.mark.parametrize("keep", ["periods", "curves"])
def test_a_file_holds_every_curve(tmp_path: Path, keep: Kept):
    TWO_PERIODS.save(tmp_path / "result.npz", keep=keep)
    saved = read_saved(tmp_path / "result.npz")
    assert ("steps" in saved) == (keep == "periods")
    for name, curve in TWO_PERIODS.curves.items():
        np.testing.assert_array_equal(saved[name], curve)
    assert {f"curve:{name}" for name in TWO_PERIODS.curves} <= set(read_arrays(tmp_path / "result.npz"))


def test_a_file_of_curves_only_cannot_be_loaded(tmp_path: Path):
    TWO_PERIODS.save(tmp_path / "result.npz", keep="curves")
    with pytest.raises(LookupError, match="learning curves alone"):
        LearningCurves.load(tmp_path / "result.npz")


def test_a_result_knows_its_point():
    assert simulate(POINT).point is POINT
    with pytest.raises(LookupError, match="without its design point"):
        _ = TWO_PERIODS.point
    known = replace(TWO_PERIODS, known_point=POINT)
    assert known.scalars() == TWO_PERIODS.scalars((20, 20))
    assert set(known.scalars()) == set(SCALARS)
    assert "total_steps_scaled" not in TWO_PERIODS.scalars()
