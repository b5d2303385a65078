"""Pictures as wide as a column: text that would overlap, and legends that would cover data."""

from __future__ import annotations

from itertools import pairwise

import matplotlib.pyplot as plt
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.text import Annotation

from rl_design_space.report import Heatmap, Interactions
from rl_design_space.report.base import MAIN
from rl_design_space.report.cells import colour_cells
from rl_design_space.report.definitions import COLUMNS
from rl_design_space.report.fitting import fit
from rl_design_space.report.graded_picture import draw_table
from rl_design_space.report.many import apart
from rl_design_space.report.style import PRINTED


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


def test_a_number_whose_interval_is_left_out_is_in_the_middle_of_its_cell_and_free_of_its_sides():
    axis = table(3, 6)
    visible = [text for text in axis.texts if text.get_visible()]
    assert {text.get_position()[1] % 1 for text in visible} == {0.5}
    axis.get_figure(root=True).set_dpi(PRINTED)  # letters are of whole pixels
    cell = axis.get_window_extent().width / 6
    assert max(text.get_window_extent().width for text in visible) < 0.9 * cell
    plt.close(axis.figure)


def test_a_label_is_broken_to_the_height_of_its_axis_and_a_ratio_stays_whole():
    figure, axes = plt.subplots(2, 1, figsize=(7, 6), layout="constrained")
    axes[0].set_ylabel("share of the variance of a long name of log(steps / optimum)")
    axes[0].set_title("\n".join("lines that take height from the axis" for _ in range(7)))
    fit(figure, 3.5, None, None)
    label = axes[0].yaxis.label
    assert label.get_window_extent().height <= 1.1 * axes[0].get_window_extent().height
    assert any("log(steps / optimum)" in line for line in label.get_text().split("\n"))
    plt.close(figure)


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


def test_square_cells_leave_nothing_empty_above_and_below_them():
    figure, axes = plt.subplots(1, 2, figsize=(11.4, 5), layout="constrained")
    for axis in axes:
        colour_cells(axis, pd.DataFrame([[1.0, 2.0], [3.0, 4.0]]), Normalize(1, 4), square=True)
    fit(figure, 3.5, None, None)
    assert figure.get_size_inches()[1] < 5 * 6 / 9
    for axis in axes:
        assert axis.get_position().height == pytest.approx(axis.get_position(original=True).height, rel=0.05)
    plt.close(figure)


def test_text_that_is_wider_than_its_axis_is_not_cut_at_the_sides():
    figure, axes = plt.subplots(2, 3, figsize=(9.6, 5), layout="constrained")
    for left, middle, right in axes:
        left.set(title="steps over optimum of the tail", xlabel="rank among the periods examined")
        middle.set_yticks(range(2), ["circle in one observation", "no circle, one observation"])
        right.imshow([[0, 1], [1, 0]])
        right.set(xticks=[], yticks=[], xlabel="period 14235, trial 79, to goal 1:\na circle of 4 steps")
    fit(figure, 3.5, None, None)
    boxes = [axis.get_tightbbox() for axis in figure.axes]
    assert min(box.x0 for box in boxes) > 0
    assert max(box.x1 for box in boxes) < figure.bbox.width
    names = [label.get_text().split() for label in axes[0, 1].get_yticklabels()]  # in its part of the picture
    assert names == [["circle", "in", "one", "observation"], ["no", "circle,", "one", "observation"]]
    plt.close(figure)


def test_definitions_below_a_table_are_upright_and_fit_their_cells():
    rows, settings = (
        ["ad_hoc", "distance", "direction"],
        [f"all goals, best by steps_after={trial}" for trial in (1, 2, 3, 4)],
    )
    cells = pd.DataFrame({"row": rows, "column": "speed", "grade": "++", "paper": "0", "measured": "1"})
    number = {"clear": 1.0, **{f"within 10 % of the optimum, {place}": 0.123 for place in range(9)}}
    definitions = pd.DataFrame(
        {**dict.fromkeys(COLUMNS, ""), "column": "speed", "definition": name, "under": under, "row": row,
         "number": number[name], "grade": "++", "paper": "0", "order": "some limits", "measured": "1"}
        for name in number for under in settings for row in rows
    )  # fmt: skip
    figure = draw_table(cells, definitions, "Table", {"ad_hoc": "ad hoc"}, "paper")
    fit(figure, 3.5, None, None)
    axis = figure.axes[1]
    headings = [text for text in axis.texts if isinstance(text, Annotation)]
    assert {text.get_rotation() for text in headings} == {90}
    assert [tick.label2.get_text() for tick in axis.xaxis.get_major_ticks()[:2]] == ["ad hoc", "distance"]
    names = [tick.label2.get_window_extent() for tick in axis.xaxis.get_major_ticks() if tick.label2.get_visible()]
    assert len(names) == 12
    assert all(one.x1 <= other.x0 for one, other in pairwise(names))
    assert min(text.get_window_extent().y0 for text in headings) > max(box.y1 for box in names)
    inside = [text for text in axis.texts if text not in headings and text.get_visible()]
    assert {text.get_text() for text in inside} == {"++", "0", "1", "✓"}  # 0.123 could not be read
    wide = axis.get_window_extent().width / 16
    assert max(text.get_window_extent().width for text in inside) <= wide + 1
    plt.close(figure)
