"""Ctrl-C: the first ends the command in good order, those that follow at once are the same, a later one ends it."""

from __future__ import annotations

import gc
import signal
from contextlib import suppress
from types import ModuleType

import pytest

from rl_design_space.commands import cli, report
from rl_design_space.commands.interrupts import Interrupts


def test_impatient_interrupts_are_one_and_a_later_one_ends_the_process(capfd: pytest.CaptureFixture[str]):
    now, ended = [10.0], list[int]()
    handler = Interrupts(lambda: now[0], ended.append, "to write the report")
    with pytest.raises(KeyboardInterrupt):
        handler(signal.SIGINT, None)
    for now[0] in (10.0, 10.1, 10.5, 11.9):
        handler(signal.SIGINT, None)
    assert ended == []
    now[0] = 12.1
    handler(signal.SIGTERM, None)
    assert ended == [130]
    again = "run the same command again to write the report"
    assert capfd.readouterr().err == f"interrupted again: ended at once; {again}\n"


@pytest.mark.parametrize("command", [cli, report])
def test_a_command_ends_without_looking_for_garbage(command: ModuleType, monkeypatch: pytest.MonkeyPatch):
    at_exit: list[object] = []
    monkeypatch.setattr("atexit.register", at_exit.append)
    monkeypatch.setattr(command, "handle_interrupts", lambda *_: None)
    monkeypatch.setattr("gc.set_threshold", lambda *_: None)
    monkeypatch.setattr("sys.argv", ["command", "--version"])
    with suppress(SystemExit):
        command.main()
    assert gc.freeze in at_exit
