"""The help of the commands lists studies and subcommands."""

from __future__ import annotations

import re
import sys

import pytest

from rl_design_space._paths import CONF
from rl_design_space.catalogue.overview import columns
from rl_design_space.commands import report, words


def test_the_help_of_the_report_lists_the_studies(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", ["rl-design-report", "--help"])
    with pytest.raises(SystemExit):
        report.main()
    listed = capsys.readouterr().out.partition("studies:\n")[2]
    reported = {file.stem for file in CONF.glob("study/*.yaml") if "\nreport:" in file.read_text(encoding="utf-8")}
    assert reported <= set(listed.split())
    assert re.search(r"paper +All tables, figures and claims of the paper", listed)


def test_every_command_has_a_summary_of_one_sentence():
    assert list(words.summaries()) == words.names()
    assert {"list", "show"} <= set(words.names())
    assert all(summary and not summary.endswith(".") for summary in words.summaries().values())


def test_names_are_padded_to_the_widest_and_descriptions_wrap():
    lines = list(columns({"a": "word " * 30, "long": ""}))
    assert lines[0].startswith("  a     word word")
    assert lines[1].startswith("        word")
    assert lines[-1] == "  long"
    assert list(columns({})) == []
