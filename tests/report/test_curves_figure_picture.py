"""A figure of learning curves draws what its CSV holds, with lines that differ without colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from rl_design_space.learning import simulate
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report import CurvesFigure
from rl_design_space.report.runs import Runs
from rl_design_space.report.style import DASHES
from tests.points import planning, shipped_study
from tests.report.readers import LearningReader

SWEEP = ["task.periods=8", "task.trials=10", "world.size=4", "exploration=linear", "exploration.k=0.02,0.05,0.1"]
FIGURE = CurvesFigure(
    title="Curves",
    shows="Three lines",
    panels=[{"title": "all", "where": {}, "lines": {f"k = {k}": {"exploration.k": k} for k in (0.02, 0.05, 0.1)}}],
)
SHIPPED = ["fig2", "fig3", "fig4", "fig5"]


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        return Study("mine", (), planner.composer.config(()), plan_overrides(SWEEP, planner))


@pytest.fixture(scope="module")
def written(study: Study, tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """The CSV of the figure."""
    folder = tmp_path_factory.mktemp("curves")
    FIGURE.write(study, LearningReader(study.plan), folder)
    return pd.read_csv(folder / "mine.csv")


@pytest.fixture
def axes(study: Study) -> Iterator[tuple[Axes, Axes]]:
    """The curves, and the share of failed trials below."""
    drawn = FIGURE.draw(FIGURE.frames(Runs.of_study(study, LearningReader(study.plan))))
    yield drawn.axes[0], drawn.axes[1]
    plt.close(drawn)


def test_heading_and_note_are_not_wider_than_a_single_panel(study: Study):
    figure = replace(FIGURE, title="Steps of a trial with three schedules that decay linearly, and a long heading, too")
    drawn = figure.draw(figure.frames(Runs.of_study(study, LearningReader(study.plan))))
    drawn.draw_without_rendering()
    for text in (drawn._suptitle, drawn._supxlabel):
        box = text.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= drawn.bbox.width
    plt.close(drawn)


def test_the_csv_holds_every_curve_that_is_drawn(written: pd.DataFrame, axes: tuple[Axes, Axes]):
    for axis, column in zip(axes, ("mean", "failed"), strict=True):
        curves = [line.get_ydata() for line in axis.lines if len(line.get_ydata()) == 10]
        expected = [curve[column].to_numpy() for _, curve in written.groupby("line", sort=False)]
        assert len(curves) == 3
        np.testing.assert_allclose(curves, expected, atol=1e-12)


def test_the_csv_holds_every_band_that_is_drawn(written: pd.DataFrame, axes: tuple[Axes, Axes]):
    bands = [band for band in axes[0].collections if isinstance(band, PolyCollection)]
    assert len(bands) == 3
    for band, (_, curve) in zip(bands, written.groupby("line", sort=False), strict=True):
        corners = {tuple(corner) for corner in band.get_paths()[0].vertices.round(6)}
        for bound in ("ci_low", "ci_high"):
            assert set(curve[["trial", bound]].round(6).itertuples(index=False, name=None)) <= corners


def test_the_optimum_and_a_random_walk_stand_beside_the_curves(study: Study, axes: tuple[Axes, Axes]):
    (optimum, walk) = sorted(line.get_ydata()[0] for line in axes[0].lines if len(line.get_ydata()) == 2)
    assert optimum == pytest.approx(simulate(study.plan[0].point, threads=1).optimum.mean())
    assert walk > 3 * optimum


@pytest.mark.parametrize("name", SHIPPED)
def test_lines_of_a_panel_differ_without_colours(name: str):
    figure: CurvesFigure = shipped_study(name).report()
    assert len({str(dashes) for dashes in DASHES}) == len(DASHES)
    for panel in figure.built_panels():
        assert len(panel.lines) <= len(DASHES)


@pytest.mark.parametrize("name", SHIPPED)
def test_pictures_are_described_in_one_plain_line(name: str):
    shows = shipped_study(name).report().shows
    assert 40 < len(shows) < 300
    assert not set(shows) & set("[]()\n")


def test_files_are_the_same_every_time(study: Study, tmp_path: Path):
    for folder in ("one", "two"):
        FIGURE.write(study, LearningReader(study.plan), tmp_path / folder)
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in ("one", "two"))
    assert one == two
    assert {Path(name).suffix for name in one} == {".png", ".svg", ".csv", ".md"}
