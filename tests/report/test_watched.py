"""A period to look at: its figure, its animations, and the page with a slider in a real browser."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.quiver import Quiver
from PIL import Image

import rl_design_space as rds
from rl_design_space.design import WAIT
from rl_design_space.report.inside.animation import Frames, trials_shown
from rl_design_space.report.inside.grid import Grid
from rl_design_space.report.inside.picture import Picture, value_norm
from rl_design_space.report.inside.watched import Watched
from tests.browser import needs_browser, opened

POINT = rds.DesignPoint(
    representation=rds.Direction(),
    world=rds.Torus(size=(5, 4)),
    exploration=rds.Linear(k=0.1),
    task=rds.Task(goals=2, trials=15, periods=4),
)


@pytest.fixture(scope="module")
def watched() -> Watched:
    return rds.watch(POINT, period="worst", trial=3)


@pytest.fixture(scope="module")
def frames(watched: Watched) -> Frames:
    return watched.frames(3)


def test_the_period_is_the_one_asked_for(watched: Watched):
    curves = rds.simulate(POINT)
    assert watched.period == int(curves.total_steps.argmax())
    assert rds.watch(POINT, period=2).title.startswith("period 2: ")
    assert "(worst of 4 periods)" in watched.title
    np.testing.assert_array_equal(watched.inside.steps, curves.steps[watched.period])
    with pytest.raises(rds.ConfigError, match="period=worse"):
        rds.watch(POINT, period="worse")
    with pytest.raises(rds.ConfigError, match="point=direction: should be a DesignPoint"):
        rds.watch("direction")


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan])
def test_values_that_are_not_finite_are_refused(watched: Watched, value: float):
    values = np.where(watched.snapshot.learned, value, 0.0)
    with pytest.raises(rds.ConfigError, match="reward: after trial 3, Q-values are infinite or not a number"):
        value_norm((replace(watched.snapshot, values=values),))


def test_an_action_that_waits_is_a_circle(watched: Watched):
    greedy = watched.snapshot.greedy[0]
    cell, action = np.argwhere(greedy & (watched.snapshot.learned[0] & (greedy.sum(axis=1) == 1))[:, np.newaxis])[0]
    made = watched.inside.made.copy()
    made[action, 0, cell] = WAIT
    figure = Picture(replace(watched.inside, made=made), watched.snapshot, "waiting").figure
    (circles,) = (each for each in figure.axes[0].collections if isinstance(each, PathCollection))
    assert circles.get_offsets().tolist() == [[cell % 5, cell // 5]]
    assert "action that waits in this cell" in [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close(figure)


def test_the_figure_shows_values_arrows_and_visits(watched: Watched):
    above, below = watched.figure.axes[:2], watched.figure.axes[2:4]
    assert [axis.get_title() for axis in above] == ["to goal 1", "to goal 2"]
    for goal, (values, visits) in enumerate(zip(above, below, strict=True)):
        shown = values.images[0].get_array()
        np.testing.assert_array_equal(~shown.mask.ravel(), watched.snapshot.learned[goal])
        np.testing.assert_array_equal(shown.compressed(), watched.snapshot.values[goal][watched.snapshot.learned[goal]])
        assert visits.images[0].get_array().sum() == watched.snapshot.visits[goal].sum()
        (arrows,) = (each for each in values.collections if isinstance(each, Quiver))
        greedy = watched.snapshot.greedy[goal]
        drawn = watched.snapshot.learned[goal] & ~greedy.all(axis=1)
        drawn[watched.inside.goals[goal]] = False
        assert len(arrows.U) == greedy[drawn].sum()
    assert "after trial 3: " in watched.figure.get_suptitle()
    assert {text.get_text() for text in above[0].texts} == {"1", "2", "S"}


def test_a_step_over_the_border_is_drawn_at_both_sides():
    grid = Grid(POINT)
    lines, owners = grid.segments(np.array([[0, 1], [0, 4], [15, 0], [3, 3]], dtype=np.int32))
    assert owners.tolist() == [0, 1, 1, 2, 2]
    assert [line.tolist() for line in lines[1:3]] == [[[0, 0], [-0.5, 0]], [[4.5, 0], [4, 0]]]
    assert [line.tolist() for line in lines[3:]] == [[[0, 3], [0, 3.5]], [[0, -0.5], [0, 0]]]


def test_walls_are_where_no_step_leads():
    walled = rds.watch(rds.DesignPoint(world=rds.Walled(size=3), task=rds.Task(goals=1, trials=2, periods=1)), 0)
    lines = (each for each in walled.figure.axes[0].collections if isinstance(each, LineCollection))
    (walls,) = (each for each in lines if each.get_zorder() == 3)
    assert len(walls.get_segments()) == 4 * 3


def test_files_are_named_after_their_stem(watched: Watched, tmp_path: Path):
    paths = watched.save(tmp_path / "here")
    assert [path.name for path in paths] == ["here.png", "here.svg"]
    assert all(path.stat().st_size > 1000 for path in paths)


@pytest.mark.parametrize(("trials", "number"), [(100, 30), (3, 30), (100, 2)])
def test_an_animation_has_the_first_and_the_last_trial(trials: int, number: int):
    shown = trials_shown(trials, number, [trials - 2])
    assert (shown[0], shown[-1]) == (0, trials - 1)
    assert trials - 2 in shown
    assert len(shown) <= number + 1


def test_a_gif_has_a_picture_of_each_trial(frames: Frames, tmp_path: Path):
    with Image.open(frames.write_gif(tmp_path / "grows.gif")) as gif:
        assert gif.n_frames == len(frames.trials) == len({image.tobytes() for image in frames.images})


_USE = """<script>
addEventListener("load", () => {
  const slider = document.getElementById("at"), said = document.getElementById("told");
  slider.value = 0;
  slider.dispatchEvent(new Event("input"));
  const first = said.value;
  document.getElementById("play").click();
  setTimeout(() => { document.title = [first, said.value, location.hash, slider.value].join("|"); }, 2500);
});
</script>"""


@needs_browser
def test_the_slider_and_the_button_show_other_trials(frames: Frames, tmp_path: Path):
    page = frames.write_page(tmp_path / "grows.html")
    html = page.read_text(encoding="utf-8")
    assert not re.search(r'(?:src|href)="(?!data:)', html)
    page.write_text(html.replace("</body>", f"{_USE}</body>"), encoding="utf-8")
    document, complaints = opened(page, tmp_path / "profile")
    assert not complaints
    title = re.search(r"<title>(.*?)</title>", document)[1]
    first, last, address, value = title.split("|")
    assert (first, last) == (frames.texts[0], frames.texts[-1])
    assert (address, value) == (f"#trial={frames.trials[-1]}", str(len(frames.trials) - 1))
