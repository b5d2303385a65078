"""Figures of learning curves, from points to files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rl_design_space.errors import ConfigError
from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report.base import MAIN
from rl_design_space.report.curves_figure import EXPLORATION, LINES, CurvesFigure
from rl_design_space.report.runs import Runs
from tests.points import planning, shipped_study
from tests.report.readers import LearningReader, unpadded

SWEEP = ["task.periods=6", "task.trials=12", "world.size=4", "exploration=linear", "exploration.k=0.02,0.05"]
TWO = {"k = 0.02": {"exploration.k": 0.02}, "k = 0.05": {"exploration.k": 0.05}}
PANELS = [
    {"title": side, "where": {"representation": name}, "lines": TWO}
    for side, name in (("left", "ad_hoc"), ("right", "direction"))
]
FIGURE = CurvesFigure(
    title="Curves", shows="Two lines in two panels", panels=PANELS, families={"linear": {"exploration": "linear"}}
)


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        return Study(
            "mine",
            (),
            planner.composer.config(()),
            plan_overrides([*SWEEP, "representation=ad_hoc,direction"], planner),
        )


def test_a_line_is_a_point_and_the_frame_is_what_was_learned(study: Study):
    runs = Runs.of_study(study, LearningReader(study.plan))
    points = FIGURE.points(runs)
    assert list(points) == [(side, name) for side in ("left", "right") for name in ("k = 0.02", "k = 0.05")]
    frame = FIGURE.frames(runs)[MAIN].set_index(["panel", "line"])
    for line, (point,) in points.items():
        expected = simulate(point.planned.point).steps.mean(axis=0)
        assert frame.loc[line, "mean"].tolist() == pytest.approx(expected.tolist())


def test_files_hold_what_is_drawn(study: Study, tmp_path: Path):
    paths = FIGURE.write(study, LearningReader(study.plan), tmp_path)
    expected = {f"mine.{suffix}" for suffix in ("png", "svg", "csv", "md")} | {"mine_exploration.csv"}
    assert {path.name for path in paths} == expected
    assert len(pd.read_csv(tmp_path / "mine.csv")) == 4 * 12
    exploration = pd.read_csv(tmp_path / "mine_exploration.csv")
    assert exploration["exploration"].round(9).tolist() == [
        round(float(np.maximum(0.9 - k * np.arange(12), 0).sum()), 9) for k in (0.02, 0.05) * 2
    ]
    text = (tmp_path / "mine.md").read_text(encoding="utf-8")
    assert "![Two lines in two panels](mine.png)" in text
    assert "rl-design-space study=mine" in text
    assert unpadded(text).count("| left | k = ") == unpadded(text).count("| right | k = ") == 2
    picture = (tmp_path / "mine.svg").read_text(encoding="utf-8")
    assert "quick look: 6 periods" in picture


def test_missing_lines_are_named_and_nothing_at_all_can_be_drawn(study: Study, tmp_path: Path):
    first = study.plan[0]
    FIGURE.write(study, LearningReader(study.plan, {first.fingerprint}), tmp_path / "one")
    text = (tmp_path / "one" / "mine.md").read_text(encoding="utf-8")
    assert f"missing: `{first.command}`" in text
    assert "**Missing: 1 of 4 points**" in text
    assert "(missing)" in (tmp_path / "one" / "mine.svg").read_text(encoding="utf-8")
    FIGURE.write(study, LearningReader(study.plan, {p.fingerprint for p in study.plan}), tmp_path / "all")
    assert pd.read_csv(tmp_path / "all" / "mine.csv").empty


def test_a_line_that_is_not_one_point_is_refused(study: Study):
    panels = [{"title": "left", "where": {}, "lines": {"k": {"exploration.k": 0.02}}}]
    runs = Runs.of_study(study, LearningReader(study.plan))
    with pytest.raises(ConfigError, match="should be one point of sweep, not 2"):
        CurvesFigure(title="-", shows="-", panels=panels).frames(runs)
    with pytest.raises(ConfigError, match=r"study\.report\.panels\.0\.lines"):
        CurvesFigure(title="-", shows="-", panels=[{"title": "left", "where": {}, "lines": {}}]).frames(runs)


@pytest.mark.parametrize("name", ["fig2", "fig3", "fig4", "fig5"])
def test_every_line_of_the_shipped_figures_is_a_point(name: str):
    shipped = shipped_study(name)
    figure: CurvesFigure = shipped.report()
    reader = LearningReader(shipped.plan, {planned.fingerprint for planned in shipped.plan})
    points = figure.points(Runs.of_study(shipped, reader))
    assert len({point.planned.fingerprint for (point,) in points.values()}) == len(points)


def test_missing_lines_have_no_numbers(study: Study):
    reader = LearningReader(study.plan, {study.plan[0].fingerprint})
    lines = FIGURE.frames(Runs.of_study(study, reader))[LINES]
    assert lines["total_steps"].isna().tolist() == [True, False, False, False]


def test_points_are_joined_where_one_parameter_varies(study: Study):
    runs = Runs.of_study(study, LearningReader(study.plan))
    everything = [{"title": "all", "where": {}, "lines": {"one": {"exploration.k": 0.02, "representation": "ad_hoc"}}}]
    for panels, joined in ((PANELS, True), (everything, False)):
        points = replace(FIGURE, panels=panels).frames(runs)[EXPLORATION]
        assert points["joined"].tolist() == [joined] * 4
