"""The parts of a step are timed on real lanes, and add up to less than the whole."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks import roofline


def test_every_part_and_look_up_is_timed_in_every_round():
    calls = roofline.measure(rounds=2, report=lambda _: None, turns=10, look_ups=1000, footprints_kib=(16, 128))
    parts = [roofline.WHOLE, roofline.DECIDE, roofline.MOVE, roofline.UPDATE, roofline.KEEP]
    assert calls["case"].tolist() == 2 * [*parts, roofline.WAIT, roofline.WAIT]
    assert (calls["ns"] > 0).all()


def test_shares_are_taken_within_a_round():
    whole, decide = {0: 10.0, 1: 20.0, 2: 30.0}, {0: 1.0, 1: 2.0, 2: 3.0}
    rows = [(roofline.WHOLE, 0, round_, ns) for round_, ns in whole.items()]
    rows += [(roofline.DECIDE, 0, round_, ns) for round_, ns in decide.items()]
    rows += [(roofline.WAIT, 16, round_, 5.0) for round_ in whole]
    frame = roofline.summary(pd.DataFrame(rows, columns=["case", "kib", "round", "ns"])).set_index("case")
    assert frame.loc[roofline.DECIDE, "share"] == pytest.approx(0.1)
    assert np.isnan(frame.loc[roofline.WAIT, "share"])
    assert roofline.text_of(frame.reset_index())["part"].tolist()[-1] == "look-up that waits, 16 KiB"


@pytest.mark.parametrize("kib", [1, 16])
def test_the_look_ups_go_through_every_line(kib: int):
    chain, at, seen = roofline._chain(kib), 0, set()
    while at not in seen:
        seen.add(at)
        at = int(chain[at])
    assert len(seen) == kib * 1024 // 64
