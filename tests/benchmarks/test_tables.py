"""Numbers are written with the digits that they deserve, tables so that nothing breaks them."""

from __future__ import annotations

import math

import pandas as pd
import pytest

from benchmarks.__main__ import main
from benchmarks.tables import markdown, number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (12345.6, "12,346"),
        (123.4, "123"),
        (12.34, "12.3"),
        (1.234, "1.23"),
        (0.01234, "0.012"),
        (-2.345, "-2.35"),
        (0.0, "0"),
        (math.nan, "–"),
        (math.inf, "inf"),
    ],
)
def test_three_digits(value: float, text: str):
    assert number(value) == text


def test_a_bar_in_a_cell_does_not_split_it():
    lines = markdown(pd.DataFrame({"a": ["x|y"], "b": ["z"]})).splitlines()
    assert [line.count("|") for line in lines] == [3, 3, 3]


def test_the_command_refuses_an_unknown_part(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit, match="2"):
        main(["--only", "everything"])
    assert "race" in capsys.readouterr().err
