"""Errors on the command line: a message and exit status 2, or a traceback."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path

import pytest

from rl_design_space.commands import words
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.commands.report import write_report
from rl_design_space.commands.terminal import Terminal
from rl_design_space.errors import ConfigError
from rl_design_space.run.outcome import PointFailedError

#: Ways to write to the output; each test has a terminal of its own, because Rich keeps what it could not write.
WAYS = (print, lambda text: Terminal().print(text))
AWAY = ("tracking=server", "tracking.uri=http://127.0.0.1:9")


def test_an_error_that_a_user_can_fix_is_a_message(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as exit_, shown_as_messages():
        raise ConfigError.at("world.size", 1, "should be at least 2")
    assert exit_.value.code == 2
    assert capsys.readouterr().err == "error: world.size=1: should be at least 2\n"


@pytest.mark.parametrize("purpose", [(), ("to write the report",)])
def test_an_interrupt_is_a_message(purpose: tuple[str, ...], capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as exit_, shown_as_messages(*purpose):
        raise KeyboardInterrupt
    assert exit_.value.code == 130
    assert capsys.readouterr().err == f"interrupted; run the same command again {''.join(purpose) or 'to continue'}\n"


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (PointFailedError("NameError: x (mine.py:3)"), "failed: NameError: x (mine.py:3)\n"),
        (MemoryError("Unable to allocate 3 TiB"), "error: not enough memory: Unable to allocate 3 TiB\n"),
        (OSError(errno.ENOSPC, "No space left on device"), "cannot be written: No space left on device\n"),
    ],
    ids=["point", "memory", "disk"],
)
def test_what_a_command_cannot_help_is_a_message_with_status_one(
    error: Exception, message: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as exit_, shown_as_messages():
        raise error
    assert exit_.value.code == 1
    assert capsys.readouterr().err.endswith(message)


@pytest.mark.parametrize("written", WAYS, ids=["print", "rich"])
def test_a_full_output_is_a_message(
    written: Callable[[str], None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr("sys.stdout", full)
        with pytest.raises(SystemExit) as exit_, shown_as_messages():
            written("text")
    assert exit_.value.code == 1
    assert capsys.readouterr().err == "error: the output cannot be written: No space left on device\n"


@pytest.mark.parametrize("written", WAYS, ids=["print", "rich"])
def test_an_output_that_nobody_reads_ends_the_command_without_a_message(
    written: Callable[[str], None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    reading, writing = os.pipe()
    os.close(reading)
    with open(writing, "w", encoding="utf-8") as closed:  # noqa: PTH123  (a descriptor)
        monkeypatch.setattr("sys.stdout", closed)
        with pytest.raises(SystemExit) as exit_, shown_as_messages():
            written("text")
    assert exit_.value.code == 141
    assert capsys.readouterr().err == ""


def test_characters_that_a_terminal_does_not_know_are_replaced(monkeypatch: pytest.MonkeyPatch):
    written = BytesIO()
    monkeypatch.setattr("sys.stdout", TextIOWrapper(written, encoding="ascii"))
    with shown_as_messages():
        print("probability ε")
        Terminal().print("− 5", highlight=False)
    assert written.getvalue() == b"probability ?\n? 5\n"


def test_warnings_of_libraries_are_no_errors(monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder):
    monkeypatch.setattr("sys.warnoptions", ["error"])
    monkeypatch.setenv("PYTHONWARNINGS", "error")
    with warnings.catch_warnings(), shown_as_messages():
        warnings.simplefilter("error", append=True)
        warnings.warn("deprecated", DeprecationWarning, stacklevel=1)
    assert os.environ["PYTHONWARNINGS"].startswith("default,ignore::DeprecationWarning,")


def test_any_other_error_passes():
    with pytest.raises(ZeroDivisionError), shown_as_messages():
        raise ZeroDivisionError


@pytest.mark.parametrize("value", [None, "0"])
def test_the_environment_is_left_as_it_was(monkeypatch: pytest.MonkeyPatch, value: str | None):
    monkeypatch.delenv("HYDRA_FULL_ERROR", raising=False)
    if value is not None:
        monkeypatch.setenv("HYDRA_FULL_ERROR", value)
    with shown_as_messages():
        assert os.environ["HYDRA_FULL_ERROR"] == "1"
    assert os.environ.get("HYDRA_FULL_ERROR") == value


@pytest.mark.parametrize(
    "command",
    [
        lambda: words.run("store", ["status", *AWAY]),
        lambda: words.run("ui", AWAY),
        lambda: write_report("table4", list(AWAY)),
    ],
    ids=["store", "ui", "report"],
)
def test_a_store_that_is_away_is_a_message(
    command, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("MLFLOW_HTTP_REQUEST_MAX_RETRIES", "0")  # the usual two take seconds
    with pytest.raises(SystemExit) as exit_, shown_as_messages():
        command()
    assert exit_.value.code == 2
    message = capsys.readouterr().err
    assert message.startswith(
        "error: the tracking store cannot be reached at the moment: http://127.0.0.1:9: API request"
    )
    assert message.endswith("tracking.uri=URI names another store\n")
