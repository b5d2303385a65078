"""Commands are waited for until their last record is in the store."""

from __future__ import annotations

import pytest

from benchmarks import waits


def test_a_command_is_waited_for():
    cases = waits.waits()
    assert [case.goal for case in cases.values()][2:] == [4, 15, 240]
    calls = waits.measure(1, lambda _: None, cases={"help": waits.Wait((*waits.COMMAND, "--version", ""), 1)})
    assert 0 < calls["first"][0] <= calls["seconds"][0]
    assert len(waits.text_of(waits.summary(calls))) == 1


def test_a_command_that_fails_is_reported():
    with pytest.raises(RuntimeError, match="ended with status 2"):
        waits.measure(1, lambda _: None, cases={"typo": waits.Wait((*waits.COMMAND, "colour=red", "outputs="))})
