"""Lines for the terminal."""

from __future__ import annotations

import shlex
from io import StringIO

import pytest
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.commands.terminal import Terminal, pending_line
from rl_design_space.errors import ConfigError
from rl_design_space.run.settings import store_of
from rl_design_space.tracking.tracker import DeliveryStatus


@pytest.mark.parametrize("spools", ["outputs/spool", "srv/spool", "/tmp/it's here/spool", "~/out [1]/spool"])
def test_the_hint_names_the_folder_in_which_sync_finds_the_records(spools: str):
    line = pending_line(DeliveryStatus(pending=5, reason="it is away", spools=spools), "http://127.0.0.1:9")
    about, hint = line.splitlines()
    assert about == "5 results of this and earlier commands safe on disk, not yet in http://127.0.0.1:9: it is away"
    command, word, *settings = shlex.split(hint.removeprefix("to deliver them once it is back: "))
    assert (command, word) == ("rl-design-space", "sync")
    expected = store_of([f'tracking.spool="{spools}"']).spool
    assert store_of(settings).spool == expected


#: Sets the title of the window, in two ways; rings; goes back to the beginning of the line; reverses what follows.
HOSTILE = "a\x1b]0;title\x07 b\x9b2J c\r d\u202e"
SHOWN = r"a\x1b]0;title\x07 b\x9b2J c\r d\u202e"


def table_of(text: str) -> Table:
    table = Table()
    table.add_row(text)
    return table


@pytest.mark.parametrize("shape", [str, Text, table_of], ids=["line", "styled", "table"])
def test_names_from_a_store_send_no_commands_to_the_terminal(shape: type[RenderableType]):
    terminal = Terminal(file=StringIO(), force_terminal=True, width=200, color_system="standard", highlight=False)
    terminal.print(shape(HOSTILE), style="red", markup=False)
    output = terminal.file.getvalue()
    assert "\x1b[31m" in output, "colours stay"
    for character in ("\x1b]", "\x07", "\x9b", "\r", "\u202e"):
        assert character not in output
    for visible in (r"a\x1b]0;title", r" b\x9b2J c", r"\u202e"):
        assert visible in output


def test_errors_send_no_commands_to_the_terminal(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit), shown_as_messages():
        raise ConfigError(f"{HOSTILE}: no such run\nnor another\tone")
    assert capsys.readouterr().err == f"error: {SHOWN}: no such run\nnor another\tone\n"
