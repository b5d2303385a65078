"""Comparison of measured with published values, on frames built by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from rl_design_space.analysis.published import compare_with_published
from rl_design_space.analysis.statistics import mean_estimate, top_percent_weight

COLUMNS = [
    "paper",
    "measured",
    "ci_low",
    "ci_high",
    "ratio",
    "failed_periods",
    "failed_low",
    "failed_high",
    "top_percent",
]
PUBLISHED = pd.DataFrame(
    [("b", 20, 1, 100.0), ("b", 10, 1, 200.0), ("a", 20, 1, 50.0), ("a", 10, 1, 25.0)],
    columns=["panel", "size", "goals", "paper"],
)


def periods(*cells: tuple[str, int, list[float], list[bool]]) -> pd.DataFrame:
    frames = [
        pd.DataFrame({"panel": panel, "size": size, "goals": 1, "value": values, "failed": failed})
        for panel, size, values, failed in cells
    ]
    return pd.concat(frames)


@pytest.fixture
def table() -> pd.DataFrame:
    measured = periods(
        ("a", 10, [20.0, 30.0, 40.0, 30.0], [False, False, True, False]),
        ("b", 20, [100.0, 120.0], [True, True]),
        ("c", 99, [1.0, 2.0], [False, False]),
    )
    return compare_with_published(measured, PUBLISHED)


def cell(table: pd.DataFrame, panel: str, size: int) -> pd.Series:
    (found,) = [row for _, row in table.iterrows() if (row["panel"], row["size"]) == (panel, size)]
    return found


def test_rows_and_columns_are_those_of_the_published_table(table: pd.DataFrame):
    assert list(table.columns) == ["panel", "size", "goals", *COLUMNS]
    pd.testing.assert_frame_equal(table[list(PUBLISHED.columns)], PUBLISHED)


def test_a_measured_cell_holds_its_statistics(table: pd.DataFrame):
    values = np.array([20.0, 30.0, 40.0, 30.0])
    found, estimate = cell(table, "a", 10), mean_estimate(values)
    assert found["measured"] == 30.0
    assert (found["ci_low"], found["ci_high"]) == (estimate.low, estimate.high)
    assert found["ratio"] == pytest.approx(30 / 25)
    assert found["failed_periods"] == 0.25
    assert found["top_percent"] == top_percent_weight(values)
    assert cell(table, "b", 20)["failed_periods"] == 1.0


@pytest.mark.parametrize(("panel", "size"), [("b", 10), ("a", 20)])
def test_a_cell_that_was_not_measured_is_not_a_number(table: pd.DataFrame, panel: str, size: int):
    found = cell(table, panel, size)
    assert found["paper"] in (200.0, 50.0)
    assert found[COLUMNS[1:]].isna().all()


def test_a_cell_that_was_not_published_is_left_out(table: pd.DataFrame):
    assert "c" not in set(table["panel"])


@pytest.mark.parametrize(
    "nothing",
    [
        pd.DataFrame(columns=["panel", "size", "goals", "value", "failed"]),
        periods(("c", 99, [1.0, 2.0], [False, False])),
    ],
    ids=["no period", "no such cell"],
)
def test_a_table_without_measurements_keeps_its_shape(nothing: pd.DataFrame):
    table = compare_with_published(nothing, PUBLISHED)
    pd.testing.assert_frame_equal(table[list(PUBLISHED.columns)], PUBLISHED)
    assert table[COLUMNS[1:]].isna().all(axis=None)
    assert set(table[COLUMNS[1:]].dtypes) == {np.dtype(float)}


def test_the_order_of_the_periods_does_not_matter_for_the_value():
    values = [20.0, 30.0, 40.0, 35.0]
    one = compare_with_published(periods(("a", 10, values, [False] * 4)), PUBLISHED)
    other = compare_with_published(periods(("a", 10, values[::-1], [False] * 4)), PUBLISHED)
    assert cell(one, "a", 10)["measured"] == cell(other, "a", 10)["measured"]


def test_a_single_period_has_a_value_and_no_interval():
    found = cell(compare_with_published(periods(("a", 10, [50.0], [False])), PUBLISHED), "a", 10)
    assert (found["measured"], found["ratio"]) == (50.0, 2.0)
    assert np.isnan(found["ci_low"])
    assert np.isnan(found["ci_high"])


def test_keys_may_have_any_name():
    published = pd.DataFrame({"who": ["x", "y"], "paper": [1.0, 2.0]})
    measured = pd.DataFrame({"who": ["y", "y"], "value": [3.0, 5.0], "failed": [False, False]})
    table = compare_with_published(measured, published)
    assert table["measured"].tolist()[1] == 4.0
    assert np.isnan(table["measured"].tolist()[0])


def test_a_cell_that_was_published_twice_is_refused():
    measured = periods(("a", 10, [1.0, 2.0], [False, False]))
    with pytest.raises(pd.errors.MergeError):
        compare_with_published(measured, pd.concat([PUBLISHED, PUBLISHED]))
