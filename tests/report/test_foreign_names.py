"""Names that others have chosen, as reports show them: in pictures as they are, in spreadsheets not as formulas."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rl_design_space.report import Curves, Heatmap
from rl_design_space.report.base import Report
from rl_design_space.report.runs import Runs
from rl_design_space.report.spreadsheet import without_formulas

#: Values of a parameter: formulas of Matplotlib, one of them not valid; a name that its legends leave out; LaTeX; a
#: command to a terminal, which no SVG may hold; a formula of spreadsheets.
NAMES = ("$x^2$", "$\\frac{", "_hidden", "a_b\\n%&#{}", "\x1b[2J", "=cmd|'/c calc'!A0")
SHOWN = [*NAMES[:4], r"\x1b[2J", NAMES[5]]


class Reader:
    """Every run has the same curve."""

    in_flight = 2

    def periods(self, run: object) -> dict[str, np.ndarray]:
        return {"steps/mean": np.arange(1.0, 5.0)}


@pytest.fixture
def runs() -> Runs:
    frame = pd.DataFrame({"name": NAMES, "_choice": NAMES, "total_steps": np.arange(len(NAMES)) + 1.0})
    frame = frame.assign(fingerprint=NAMES, artifacts="", seed=0, **{"task.periods": 3})
    return Runs.of_frame(frame.rename_axis("run_id"), Reader(), "the command")


@pytest.mark.parametrize("report", [Curves(by="_choice"), Heatmap(rows="_choice", cols="seed")])
def test_names_appear_as_they_are(report: Report, runs: Runs, tmp_path: Path):
    _, svg, csv, _ = report.write_runs(runs, tmp_path / "report")
    texts = {"".join(each.itertext()) for each in ET.parse(svg).iter() if each.tag.endswith("}text")}
    for name in SHOWN:
        assert {name, f"_choice={name}"} & texts
    if isinstance(report, Heatmap):
        assert {*SHOWN[:5], f"'{SHOWN[5]}"} == set(pd.read_csv(csv)["_choice"])


def test_text_is_no_formula_in_a_spreadsheet_and_numbers_stay():
    formulas = ["=1+1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-2+3+cmd|' /C calc'!A0", "\t=1", " =1", "\r=1"]
    others = ["-1", "+0.5", "-1e-3", "-1.2 – 3", "−3", "a=b", "it's", "- a line", ""]
    frame = pd.DataFrame({"text": [*formulas, *others[:-2], None], "=name": -1.5})
    guarded = without_formulas(frame)
    assert list(guarded["text"])[:-1] == [f"'{text}" for text in formulas] + others[:-2]
    assert list(guarded) == ["text", "'=name"]
    assert (guarded["'=name"] == -1.5).all()
    assert guarded["text"].isna().sum() == 1
