"""Table 4 as a report: the paper's numbers, and a small one from made-up numbers to its files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from rl_design_space.analysis.statistics import mean_estimate
from rl_design_space.commands.report import write_report
from rl_design_space.errors import ConfigError
from rl_design_space.report import PublishedTable
from rl_design_space.report.base import MAIN
from rl_design_space.report.points import largest, sample
from rl_design_space.report.runs import Runs
from tests.points import shipped_study
from tests.report.conftest import MISSING, OVERRIDES, PUBLISHED, Small
from tests.report.readers import LearningReader, unpadded

#: Table 4 of the paper: a row a grid size; ad hoc with 1, 2, 3 goals, then direction with 1, 2, 3 goals.
PAPER = """
    10   2,623   5,736   8,969    3,429   7,559  11,473
    20   8,793  20,607  31,491    7,366  23,610  33,953
    30  17,394  36,852  55,858   15,304  29,689  60,324
"""

HEADER = "representation,size,goals,paper,measured,ci_low,ci_high,ratio,failed_periods,failed_low,failed_high,periods"


def shipped() -> PublishedTable:
    return shipped_study("table4").report()


def test_the_published_numbers_are_those_of_the_paper():
    expected = {"ad_hoc": {}, "direction": {}}
    for line in PAPER.strip().splitlines():
        size, *values = (int(word.replace(",", "")) for word in line.split())
        expected["ad_hoc"][size] = dict(zip((1, 2, 3), values[:3], strict=True))
        expected["direction"][size] = dict(zip((1, 2, 3), values[3:], strict=True))
    assert shipped().published == expected


def test_every_published_cell_is_a_point_of_the_study():
    study = shipped_study("table4")
    table = study.report()
    planned = {tuple(point.parameters[name] for name in table.axes.values()) for point in study.plan}
    published = {(p, r, c) for p, rows in table.published.items() for r, columns in rows.items() for c in columns}
    assert planned == published


def test_steps_are_compared_in_moves_of_equal_length():
    assert shipped().value == "total_steps_scaled"


# A small table, from tracked runs to files.


def test_four_files_are_written_and_named_after_the_study(written: dict[str, Path]):
    assert {suffix: path.name for suffix, path in written.items()} == {
        suffix: f"table4{suffix}" for suffix in (".png", ".svg", ".csv", ".md")
    }
    assert all(path.stat().st_size > 0 for path in written.values())


def test_the_csv_has_these_columns_and_a_row_a_cell(written: dict[str, Path]):
    assert written[".csv"].read_text(encoding="utf-8").splitlines()[0] == HEADER
    cells = [(p, r, c, v) for p, rows in PUBLISHED.items() for r, cs in rows.items() for c, v in cs.items()]
    assert [tuple(row)[1:5] for row in pd.read_csv(written[".csv"]).itertuples()] == cells


def test_the_csv_holds_what_simulations_give(written: dict[str, Path], small: Small):
    table = pd.read_csv(written[".csv"]).set_index(["representation", "size", "goals"])
    for cell, curves in small.learned.items():
        totals = curves.steps.sum(axis=1) * 10 / cell[1]
        row, estimate = table.loc[cell], mean_estimate(totals)
        assert row["measured"] == pytest.approx(totals.mean(), rel=1e-12)
        assert (row["ci_low"], row["ci_high"]) == pytest.approx((estimate.low, estimate.high), rel=1e-12)
        assert row["ratio"] == pytest.approx(totals.mean() / PUBLISHED[cell[0]][cell[1]][cell[2]])
        assert row["failed_periods"] == (~curves.success).any(axis=1).mean()
    assert len(small.learned) == 10


def test_unscaled_steps_can_be_asked_for(small: Small):
    cells = replace(small.table, value="total_steps").frames(Runs.of_study(small.study, small.reader))[MAIN]
    found = cells.set_index(["representation", "size", "goals"])["measured"]
    for cell, curves in small.learned.items():
        assert found[cell] == pytest.approx(curves.steps.sum(axis=1).mean())


def test_missing_cells_are_empty_in_the_csv(written: dict[str, Path]):
    table = pd.read_csv(written[".csv"])
    keys = ["representation", "size", "goals"]
    assert {tuple(row) for row in table[table["measured"].isna()][keys].to_numpy()} == MISSING


def test_missing_cells_are_named_in_the_text_with_the_command_that_makes_them(written: dict[str, Path]):
    text = written[".md"].read_text(encoding="utf-8")
    assert f"Missing: 2 of {len(PUBLISHED) * 6} points" in text
    assert f"`rl-design-space study=table4 {' '.join(OVERRIDES)}`" in text
    missing = [line for line in text.splitlines() if "missing" in line and line.startswith("|")]
    assert {tuple(unpadded(line).strip("| ").split(" | ")[:3]) for line in missing} == {
        (p, str(r), str(c)) for p, r, c in MISSING
    }


def test_the_text_shows_the_picture_and_every_measured_cell(written: dict[str, Path]):
    text = written[".md"].read_text(encoding="utf-8")
    assert "(table4.png)" in text
    assert "20 periods a point" in text
    assert f"`rl-design-report table4 {' '.join(OVERRIDES)}`" in text
    for row in pd.read_csv(written[".csv"]).dropna().itertuples():
        beginning = f"| {row.representation} | {row.size} | {row.goals} | {row.paper:,.0f} | {row.measured:,.0f} |"
        assert beginning in unpadded(text)
        assert f"| {row.ratio:.3f} |" in unpadded(text)


def test_the_text_tells_how_far_the_table_is_from_the_paper(written: dict[str, Path]):
    table = pd.read_csv(written[".csv"]).dropna()
    for label, name in (("ad hoc", "ad_hoc"), ("direction", "direction")):
        ratio = np.log(table[table["representation"] == name]["ratio"])
        (line,) = [x for x in written[".md"].read_text(encoding="utf-8").splitlines() if "rms" in x]
        here = line[line.index(f"{label} (k") :]
        assert f"rms {np.expm1(np.sqrt((ratio**2).mean())):.1%}" in here
        assert f"largest {np.expm1(ratio.abs().max()):.1%}" in here


def test_the_picture_has_a_plausible_size(written: dict[str, Path]):
    with Image.open(written[".png"]) as picture:
        assert picture.format == "PNG"
        assert 1200 < picture.width < 3000
        assert 600 < picture.height < 1500
        # Neither blank nor cut: many colours inside, an even margin around.
        assert len(picture.convert("RGB").getcolors(maxcolors=2**24)) > 500
        border = np.asarray(picture.convert("L"))[[0, -1], :]
        assert (border == 255).all()
    assert 20_000 < written[".png"].stat().st_size < 1_000_000


def test_the_same_runs_give_the_same_files(written: dict[str, Path], small: Small, tmp_path: Path):
    again = {path.suffix: path for path in small.table.write(small.study, small.reader, tmp_path)}
    assert {suffix for suffix, path in again.items() if path.read_bytes() != written[suffix].read_bytes()} == set()


def test_cells_outside_what_was_asked_for_are_not_promised(small: Small, tmp_path: Path):
    narrow = shipped_study("table4", *OVERRIDES, "world.size=4")
    small.table.write(narrow, small.reader, tmp_path)
    text = (tmp_path / "table4.md").read_text(encoding="utf-8")
    # Of what was not run, this command makes one cell of size 4, and none of size 5.
    assert f"Missing: 1 of 6 points**; `{narrow.command}` makes them" in text
    assert "Not asked for: 6 of 12 cells." in text


def test_different_points_are_not_averaged_into_one_cell(small: Small):
    study = shipped_study("table4", *OVERRIDES, "task.trials=5,6")
    with pytest.raises(ConfigError, match=r"task\.trials"):
        small.table.frames(Runs.of_study(study, small.reader))


# What cannot be reported.


def test_a_report_without_recorded_runs_is_refused(tmp_path: Path):
    with pytest.raises(ConfigError, match="no run has been recorded there yet"):
        write_report("table4", [f"outputs={tmp_path}/none"])
    assert list(tmp_path.iterdir()) == []


def test_a_report_without_tracking_is_refused(tmp_path: Path):
    with pytest.raises(ConfigError, match="tracking=none: nothing was recorded"):
        write_report("table4", [f"outputs={tmp_path}", "tracking=none"])


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("study.report.value=steps", r"study\.report\.value=steps: should be 'total_steps' or 'total_steps_scaled'"),
        ("study.report.titel=x", r"study\.report\.titel: no such key .*did you mean study\.report\.title\?"),
        ("study.report.row=world.size", r"study\.report\.row=world\.size: should be a valid dictionary"),
    ],
)
def test_an_invalid_report_is_named_in_the_error(override: str, message: str):
    with pytest.raises(ConfigError, match=message):
        shipped_study("table4", override).report()


def test_an_axis_that_no_point_has_is_refused(small: Small):
    with pytest.raises(ConfigError, match=r"world\.siz\b"):
        replace(small.table, row={"size": "world.siz"}).frames(Runs.of_study(small.study, small.reader))


def test_a_cell_shows_the_largest_recorded_sample(small: Small):
    table = replace(small.table, larger_samples="")
    runs = Runs.of_study(small.study, small.reader)
    points = {tuple(point.key(table.axes.values())): point for point in runs.points}
    key = ("direction", 4, 2)
    larger = replace(points[key], parameters={**points[key].parameters, "task.periods": 60}, of_plan=None)
    missing = replace(larger, parameters={**points["ad_hoc", 4, 1].parameters, "task.periods": 60}, run=None)
    other = replace(larger, parameters={**larger.parameters, "exploration.k": 0.07})
    again = replace(points["ad_hoc", 5, 1])
    both = runs.with_larger(Runs([larger, missing, other, again], small.reader), "rl more")
    assert both.points == [*runs.points, larger, missing]
    assert both.made_by.endswith("Larger samples of 1 points are from runs of `rl more`.")
    chosen = largest(both.points)
    assert len(chosen) == len(runs.points)
    assert larger in chosen
    assert points["ad_hoc", 4, 1] in chosen
    assert table.frames(both)[MAIN]["periods"].tolist() == table.frames(runs)[MAIN]["periods"].tolist()


def test_the_shipped_table_names_a_study_with_larger_samples_of_its_direction_cells():
    table, tails = shipped_study("table4"), shipped_study(shipped().larger_samples)
    reader = LearningReader(table.plan)
    runs = Runs.of_study(table, reader).with_larger(Runs.of_study(tails, LearningReader(tails.plan)), tails.command)
    periods = {point.key(("representation", "world.size")): sample(point)[1] for point in largest(runs.points)}
    ad_hoc = {("ad_hoc", size): 500 for size in (10, 20, 30)}
    assert periods == {**ad_hoc, ("direction", 10): 20_000, ("direction", 20): 5000, ("direction", 30): 5000}
