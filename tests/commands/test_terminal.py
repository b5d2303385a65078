"""Lines for the terminal."""

from __future__ import annotations

import shlex

import pytest

from rl_design_space.commands.terminal import pending_line
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
