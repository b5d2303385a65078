"""Other definitions of the columns of a graded table: grades, orders and text."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rl_design_space.analysis.at_best import Judged
from rl_design_space.analysis.statistics import Estimate
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.report.definitions import defined, definitions_text, estimate_text
from rl_design_space.report.grading import Grading
from rl_design_space.report.runs import Runs
from tests.report.readers import LearningReader, unpadded
from tests.report.test_tables import shipped

ROWS = ("one", "two", "three")
PAPER = {"one": {"speed": "++"}, "two": {"speed": "0"}, "three": {"speed": "++"}}
SPEED = {"speed": {"by trials": Grading(means="trials", limits=(10, 20, 30), of="trials")}}


def speeds(*values: Estimate | Judged) -> dict[str, dict[str, Estimate | Judged]]:
    return {row: {"trials": value} for row, value in zip(ROWS, values, strict=True)}


NEVER = Judged(100, 100, np.inf, never=True)
FOUND = {
    "apart": speeds(Estimate(5, 4, 6), Estimate(40, 35, 45), Estimate(12, 11, 13)),
    "never": speeds(Estimate(5, 4, 6), NEVER, Estimate(12, 11, 13)),
    "overlapping": speeds(Estimate(5, 4, 6), Estimate(12, 5, 19), Estimate(1, 0, 2)),
    "reversed": speeds(Estimate(50, 45, 55), Estimate(12, 11, 13), Estimate(1, 0, 2)),
    "missing": {"one": {"trials": Estimate(5, 4, 6)}},
}


def test_each_setting_has_grades_and_a_verdict_on_the_order():
    frame = defined(SPEED, FOUND, ROWS, PAPER)
    assert frame["definition"].unique().tolist() == ["by trials"]
    grades = frame.groupby("under", sort=False)["grade"].agg(list).to_dict()
    assert grades["apart"] == ["++", "−", "+"]
    assert grades["missing"] == ["++", "", ""]
    orders = frame.groupby("under", sort=False)["order"].agg(lambda column: column.unique().item()).to_dict()
    assert orders == {
        "apart": "some limits",
        "never": "some limits",
        "overlapping": "cannot be told",
        "reversed": "no limits",
        "missing": "",
    }


def test_grades_that_are_none_of_ours_have_no_order():
    paper = {row: {"speed": grade} for row, grade in zip(ROWS, ("fast", "slow", "fast"), strict=True)}
    assert set(defined(SPEED, FOUND, ROWS, paper)["order"]) == {""}


@pytest.mark.parametrize(
    ("each", "text"),
    [
        (None, "missing"),
        (Estimate(1.25, 1.25, 1.25), "1.25"),
        (Estimate(5, 4, 6), "5 (4 – 6)"),
        (Estimate(5, np.nan, np.nan), "5"),
        (Judged(92, 80, np.inf), "92 (80 – ∞)"),
        (Judged(100, 85, np.inf, never=True), "≥ 100 (85 – ∞)"),
        (NEVER, "≥ 100"),
    ],
)
def test_a_number_reads_as_what_is_known_of_it(each, text: str):
    assert estimate_text(each) == text


def test_the_text_says_where_limits_would_lie():
    heading, table, how, rules = definitions_text(defined(SPEED, FOUND, ROWS, PAPER), SPEED, {}, "paper")
    assert heading == "## By other definitions"
    assert "| speed | by trials | apart | ++ 5 (4 – 6) | − 40 (35 – 45) | + 12 (11 – 13) | some (++/0: 12 – 40) |" in (
        unpadded(table)
    )
    assert "| reversed | − 50 (45 – 55) | + 12 (11 – 13) | ++ 1 (0 – 2) | none |" in unpadded(table)
    assert how.startswith("Lines for which some limits give the grades: speed 2 of 4 (1 with none).")
    assert rules == "- **speed, by trials**: trials. ++ ≤ 10, + ≤ 20, 0 ≤ 30, otherwise −."


@pytest.mark.parametrize(
    ("of", "message"),
    [("gap_closd=0.9", r"definitions\.speed\.mine\.of=gap_closd=0\.9.*gap_closed"), ("", r"speed\.mine\.of=")],
)
def test_a_definition_by_an_unknown_measure_is_refused(of: str, message: str):
    definitions = {"speed": {"mine": {"of": of, "means": "-", "limits": [1.0, 2.0, 3.0]}}}
    table = replace(shipped("table3").report(), definitions=definitions)
    with pytest.raises(ConfigError, match=message):
        table.frames(Runs([], LearningReader(Plan([]))))
