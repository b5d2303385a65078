"""Ctrl-C: the first ends the command in good order, those that follow at once are the same, a later one ends it."""

from __future__ import annotations

import signal

import pytest

from rl_design_space.commands.interrupts import Interrupts


def test_impatient_interrupts_are_one_and_a_later_one_ends_the_process(capfd: pytest.CaptureFixture[str]):
    now, ended = [10.0], list[int]()
    handler = Interrupts(lambda: now[0], ended.append)
    with pytest.raises(KeyboardInterrupt):
        handler(signal.SIGINT, None)
    for now[0] in (10.0, 10.1, 10.5, 11.9):
        handler(signal.SIGINT, None)
    assert ended == []
    now[0] = 12.1
    handler(signal.SIGTERM, None)
    assert ended == [130]
    assert capfd.readouterr().err == "interrupted again: ended at once; run the same command again to continue\n"
