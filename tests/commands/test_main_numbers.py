"""What reports print beside the paths of their files."""

from __future__ import annotations

import pytest

from rl_design_space.commands.main_numbers import tell_numbers
from rl_design_space.report.written import MainNumbers


def test_sentences_and_tables_are_printed_below_the_heading(capsys: pytest.CaptureFixture[str]):
    rows = (("[b]x[/b] `k=1`\x1b[2J", "1,000"), ("**longer than eighty columns: " + "y" * 80 + "**", "20"))
    tell_numbers([MainNumbers("Title", ("first: 1",), ("name", "steps"), rows)])
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = [line.strip() for line in printed.err.splitlines() if line.strip(" ─")]
    assert lines[:2] == ["Title", "first: 1"]
    assert lines[2].split() == ["name", "steps"]
    assert lines[3].startswith("[b]x[/b] k=1\\x1b[2J ")
    assert lines[4].startswith("longer than eighty columns: yyy")
    assert "*" not in lines[4]
    assert lines[3][-6:] == " 1,000"
    assert lines[4][-6:] == "    20"


def test_of_many_rows_and_reports_the_first_are_printed(capsys: pytest.CaptureFixture[str]):
    many = MainNumbers("Many", header=("n",), rows=tuple((str(n),) for n in range(25)))
    tell_numbers([many, MainNumbers("Sentences", tuple(f"line {n}" for n in range(21)))])
    err = capsys.readouterr().err
    assert "19" in err
    assert "24" not in err
    assert "  and 5 more rows, in the files\n" in err
    assert "line 19" in err
    assert "  and 1 more rows, in the files\n" in err
    tell_numbers([MainNumbers(f"report {n}") for n in range(10)])
    err = capsys.readouterr().err.splitlines()
    assert err[-2:] == ["report 7", "and 2 more reports; their numbers are in the files"]
    tell_numbers([])
    assert capsys.readouterr().err == ""
