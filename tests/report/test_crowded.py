"""Pictures as wide as a column: text that would overlap, and legends that would cover data."""

from __future__ import annotations

from itertools import pairwise

import matplotlib.pyplot as plt
import pandas as pd
import pytest
from matplotlib.axes import Axes

from rl_design_space.report import Heatmap, Interactions
from rl_design_space.report.base import MAIN
from rl_design_space.report.fitting import fit
from rl_design_space.report.many import apart


def table(rows: int, columns: int) -> Axes:
    """Return a heatmap of a column's width, all of whose cells are among the best."""
    cells = [
        {"msa": f"length_{y}", "k": x / 100, "value": 10000.0 + x + y, "low": 9000.0, "high": 11000.0, "in_best_set": 1}
        for y in range(rows)
        for x in range(columns)
    ]
    figure = Heatmap(rows="msa", cols="k").draw({MAIN: pd.DataFrame(cells)})
    fit(figure, 3.5, None, None)
    return figure.axes[0]


@pytest.mark.parametrize(
    ("size", "shown", "rotation"), [((3, 6), "10,000 ★", 0), ((3, 12), "10,000 ★", 90), ((3, 45), "★", 0)]
)
def test_numbers_of_small_cells_are_upright_and_a_star_stays(size: tuple[int, int], shown: str, rotation: int):
    axis = table(*size)
    visible = [text for text in axis.texts if text.get_visible()]
    assert visible[0].get_text() == shown
    assert {text.get_rotation() for text in visible} == {rotation}
    room = axis.get_window_extent()
    assert max(text.get_window_extent().width for text in visible) <= room.width / size[1] + 2  # pixels
    assert max(text.get_window_extent().height for text in visible) <= room.height / size[0] + 2
    names = [label.get_window_extent() for label in axis.get_xticklabels() if label.get_visible()]
    assert all(one.x1 < other.x0 for one, other in pairwise(names))
    plt.close(axis.figure)


def test_numbers_below_an_axis_are_left_out_where_they_overlap():
    figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
    axis.set_xticks(range(40), [f"{1000 + number:,}" for number in range(40)])
    fit(figure, 3.5, None, None)
    shown = [label.get_window_extent() for label in axis.get_xticklabels() if label.get_visible()]
    assert 4 < len(shown) < 40
    assert all(one.x1 < other.x0 for one, other in pairwise(shown))
    plt.close(figure)


def test_names_of_several_words_are_broken_before_they_are_turned():
    figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
    axis.set_xticks(range(4), ["size of state space", "perceptual aliasing", "quality", "need"])
    fit(figure, 2.5, None, None)
    names = axis.get_xticklabels()
    assert [name.get_text() for name in names[:2]] == ["size\nof\nstate\nspace", "perceptual\naliasing"]
    assert {name.get_rotation() for name in names} == {0}
    plt.close(figure)


def test_legends_of_interactions_cover_no_data_and_panels_are_one_above_the_other():
    row = {"low": 0.0, "high": 0.2, "interaction": 0.0, "reference": "msa=none"}
    frame = pd.DataFrame(
        {"pair": f"msa × {other}", "value": f"msa=length_{value}", "at": f"{other}={at}", "difference": at, **row}
        for other in ("learner", "reward")
        for value in (2, 3)
        for at in (0, 1)
    )
    figure = Interactions(width="column").draw({MAIN: frame})
    fit(figure, 3.5, None, None)
    above, below = figure.axes
    assert above.get_window_extent().y0 > below.get_window_extent().y1
    for axis in figure.axes:
        assert axis.get_legend().get_window_extent().y0 >= axis.get_window_extent().y1
        assert axis.get_window_extent().width > 200
    plt.close(figure)


def test_parameters_that_a_design_has_not_are_left_out_of_its_name():
    assert apart(["kind=linear k=1 l=–", "kind=power k=– l=2"]) == (["kind=linear k=1", "kind=power l=2"], "")
    assert apart(["k=1", "k=–"]) == (["k=1", "k=–"], "")
