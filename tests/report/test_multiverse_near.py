"""Pairs of readings that came near, and triples around them."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pandas as pd

from rl_design_space.analysis.multiverse.marks import Mark, Marked, with_triples
from rl_design_space.report.multiverse_near import near_frame
from rl_design_space.report.multiverse_outcomes import Row
from rl_design_space.report.multiverse_points import Alternative, Space, readings_of
from rl_design_space.report.multiverse_text import triples

ALTERNATIVES = [Alternative(name, frozenset({(name, 1)}), {}, name) for name in "abc"]
SPACE = Space(ALTERNATIVES, readings_of(ALTERNATIVES, 3), len(readings_of(ALTERNATIVES, 2)), ["registered"], {})
PAIR, TRIPLE = frozenset({0, 1}), frozenset({0, 1, 2})


def near(factors: dict[frozenset[int], float]) -> list[tuple]:
    """Return what came near if a value has these factors within its limit, and 0.5 under all other readings."""
    rows = [
        Row(number, 0, 0, 0, factor >= 1, what="ratio", margin=math.log(factor))
        for number, reading in enumerate(SPACE.readings)
        for factor in [factors.get(reading, 0.5)]
    ]
    wording = SimpleNamespace(name="claim", measures=["total_steps"], statistics=["mean"])
    found = SimpleNamespace(wording=wording, rows=rows, standing=list(range(len(rows))))
    frame = near_frame({"claim": found}, SPACE, 1.05)
    columns = ["reading", "triples", "hold", "nearest"]
    return list(frame[columns].itertuples(index=False, name=None))


def test_a_pair_near_its_limit_is_named_with_what_a_third_reading_does():
    assert near({PAIR: 0.96, TRIPLE: 1.2}) == [("a + b", 1, 1, "a + b + c")]
    assert near({PAIR: 0.96}) == [("a + b", 1, 0, "a + b + c")]


def test_a_pair_is_not_near_if_it_is_far_adds_nothing_or_anything_holds():
    assert near({PAIR: 0.94}) == []
    assert near({PAIR: 0.96, frozenset({0}): 0.97}) == []
    assert near({PAIR: 0.96, frozenset(): 0.96}) == []
    assert near({PAIR: 0.96, frozenset({1, 2}): 1.1}) == []


def test_a_claim_that_holds_clearly_under_a_triple_holds_under_something():
    nowhere = Marked(Mark.NOWHERE, 0.0, 0.9)
    holds, certainty = np.array([True, False]), np.array([0.99, 0.99])
    found = with_triples(nowhere, holds, certainty, {"a + b + c": np.ones(2, bool)})
    assert found == Marked(Mark.UNDER, 0.0, 0.9, ("a + b + c",), 0.5)
    assert with_triples(nowhere, holds, 0.5 * certainty, {"a + b + c": np.ones(2, bool)}) == nowhere
    assert with_triples(Marked(Mark.HOLDS, 1.0, 0.9), holds, certainty, {}).mark == Mark.HOLDS


def test_pairs_without_triples_are_to_be_named_in_the_study():
    columns = ("claim", "measure", "statistic", "reading", "factor", "triples", "hold", "nearest", "nearest_factor")
    frame = pd.DataFrame([("fig3-b", "total_steps", "mean", "a + b", 0.97, 0, 0, "", math.nan)], columns=columns)
    assert "No triples were run around a + b" in triples(frame, 1.05, 0)[1]
    assert len(triples(frame.iloc[:0], 1.05, 0)) == 1
