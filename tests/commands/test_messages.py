"""Errors on the command line: a message and exit status 2, or a traceback."""

from __future__ import annotations

import pytest

from rl_design_space.commands import words
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.commands.report import write_report
from rl_design_space.errors import ConfigError

AWAY = ("tracking=server", "tracking.uri=http://127.0.0.1:9")


def test_an_error_that_a_user_can_fix_is_a_message(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as exit_, shown_as_messages():
        raise ConfigError.at("world.size", 1, "should be at least 2")
    assert exit_.value.code == 2
    assert capsys.readouterr().err == "error: world.size=1: should be at least 2\n"


def test_any_other_error_passes():
    with pytest.raises(ZeroDivisionError), shown_as_messages():
        raise ZeroDivisionError


@pytest.mark.parametrize(
    "command",
    [
        lambda: words.run("store", ["status", *AWAY]),
        lambda: words.run("ui", AWAY),
        lambda: write_report("table4", list(AWAY)),
    ],
    ids=["store", "ui", "report"],
)
def test_a_store_that_is_away_is_a_message(command, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as exit_, shown_as_messages():
        command()
    assert exit_.value.code == 2
    message = capsys.readouterr().err
    assert message.startswith(
        "error: the tracking store cannot be reached at the moment: http://127.0.0.1:9: API request"
    )
    assert message.endswith("tracking.uri=URI names another store\n")
