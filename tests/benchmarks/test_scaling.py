"""Scaling: what is counted, what is compared with what, and that a picture comes out."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks import scaling, scaling_plot
from benchmarks.decisions import decisions_per_move
from benchmarks.tables import markdown


def test_a_decision_makes_one_move_unless_there_are_longer_actions():
    assert decisions_per_move((), periods=1) == 1.0


def test_decisions_are_fewer_than_moves_with_longer_actions():
    # Actions of 1 and 3 moves: never fewer decisions than a third of the moves.
    assert 1 / 3 < decisions_per_move((3,), periods=1) < 1


def call(panel: str, x: object, round_: int, ns: float) -> tuple[object, ...]:
    return (panel, scaling.OURS, x, "step", round_, ns * 1e-6, 1000.0, ns)


CALLS = pd.DataFrame(
    [
        *(call(scaling.WORLD, side, round_, 10.0 * (round_ + 1) * side) for round_ in (0, 1, 2) for side in (1, 3)),
        *(call(scaling.PERIODS, count, round_, 20.0 / count) for round_ in (0, 1, 2) for count in (1, 2)),
    ],
    columns=["panel", "line", "x", "unit", "round", "seconds", "units", "ns"],
)


def test_ratios_are_taken_within_a_round():
    rows = scaling.summary(CALLS).set_index(["panel", "x"])
    assert rows.loc[(scaling.WORLD, 3), "ns"] == 60.0
    assert rows.loc[(scaling.WORLD, 3), ["ratio_q25", "ratio", "ratio_q75"]].tolist() == pytest.approx([3.0, 3.0, 3.0])
    assert rows.loc[(scaling.PERIODS, 2), "ratio"] == pytest.approx(0.5)


def test_the_text_has_a_row_a_case():
    assert len(markdown(scaling.text_of(scaling.summary(CALLS))).splitlines()) == 2 + 4


def test_the_picture_is_drawn(tmp_path: Path):
    scaling_plot.plot(CALLS, tmp_path / "scaling.png")
    assert (tmp_path / "scaling.png").stat().st_size > 10_000


def test_cases_run_in_turn_and_count_steps():
    chosen = [
        case
        for case in scaling.cases(periods=2, counted_periods=1)
        if (case.panel, case.x) in {(scaling.WORLD, 10), (scaling.REPRESENTATION, "distance"), (scaling.ACTIONS, 8)}
    ]
    calls = scaling.measure(chosen, rounds=2, report=lambda _: None)
    assert calls["round"].tolist() == [0] * len(chosen) + [1] * len(chosen)
    assert set(calls["line"]) == {scaling.OURS, scaling.TEXTBOOK}
    assert (calls["units"] > 0).all()
    assert set(calls.loc[calls["panel"] == scaling.ACTIONS, "unit"]) == {"decision"}
