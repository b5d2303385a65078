"""The picture of a published table: readable on every colour, with missing cells hatched."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from rl_design_space.analysis.published import compare_with_published
from rl_design_space.report.base import MAIN
from rl_design_space.report.runs import Runs
from tests.report.conftest import MISSING, PUBLISHED, Small

GREY = (0.299, 0.587, 0.114)


@pytest.fixture
def pictured(small: Small) -> Iterator:
    """Draw these cells as the small table."""
    figures: list[Figure] = []

    def draw(cells: pd.DataFrame) -> Figure:
        figures.append(small.table.draw({MAIN: cells}))
        return figures[-1]

    yield draw
    for figure in figures:
        mpl.pyplot.close(figure)


def made_up(**columns: object) -> pd.DataFrame:
    """All cells of the small table, filled with these values."""
    keys = [(p, r, c, float(v)) for p, rows in PUBLISHED.items() for r, cs in rows.items() for c, v in cs.items()]
    cells = pd.DataFrame(keys, columns=["representation", "size", "goals", "paper"])
    cells = cells.assign(
        measured=np.nan, ci_low=np.nan, ci_high=np.nan, failed_periods=np.nan, top_percent=np.nan
    ).assign(failed_low=np.nan, failed_high=np.nan)
    cells = cells.assign(planned=True, periods=500)
    cells = cells.assign(**columns)
    return cells.assign(ratio=cells["measured"] / cells["paper"])


def full(measured: object) -> pd.DataFrame:
    measured = np.asarray(measured, dtype=float)
    return made_up(
        measured=measured,
        ci_low=0.9 * measured,
        ci_high=1.1 * measured,
        failed_periods=0.02,
        failed_low=0.01,
        failed_high=0.04,
        top_percent=5.0,
    )


def texts(axis: Axes) -> dict[tuple[int, int], list[Text]]:
    """What is written into each cell, by row and column."""
    found: dict[tuple[int, int], list[Text]] = {}
    for text in axis.texts:
        x, y = text.get_position()
        found.setdefault((int(y), int(x)), []).append(text)
    return found


def cell_colours(axis: Axes) -> np.ndarray:
    rows, columns = len(axis.get_yticks()), len(axis.get_xticks())
    axis.collections[0].update_scalarmappable()
    return axis.collections[0].get_facecolor().reshape(rows, columns, 4)[..., :3]


def relative_luminance(colour: object) -> float:
    """Of an sRGB colour, as the Web Content Accessibility Guidelines define it."""
    channels = np.asarray(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def contrast(one: object, other: object) -> float:
    low, high = sorted((relative_luminance(one), relative_luminance(other)))
    return (high + 0.05) / (low + 0.05)


def in_grey(colour: object) -> tuple[float, float, float]:
    grey = float(np.asarray(to_rgb(colour)) @ GREY)
    return (grey, grey, grey)


def test_a_panel_for_each_representation_labelled_as_asked(pictured, small: Small):
    first, second, bar = pictured(full(np.geomspace(1e3, 1e5, 12))).axes
    assert [first.get_title(), second.get_title()] == ["ad hoc (k = 0.03)", "direction (k = 0.02)"]
    assert (first.get_xlabel(), first.get_ylabel()) == ("goals n", "grid size d")
    assert [label.get_text() for label in first.get_xticklabels()] == ["1", "2", "3"]
    assert [label.get_text() for label in first.get_yticklabels()] == ["4", "5"]
    assert "logarithmic" in bar.get_ylabel()
    assert bar.figure.get_suptitle() == small.table.title


def test_a_cell_shows_measured_interval_paper_ratio_and_failures(pictured):
    figure = pictured(full(2 * made_up()["paper"]))
    for axis, panel in zip(figure.axes[: len(PUBLISHED)], PUBLISHED, strict=True):
        for row, size in enumerate((4, 5)):
            for column, goals in enumerate((1, 2, 3)):
                paper = PUBLISHED[panel][size][goals]
                assert [text.get_text() for text in texts(axis)[row, column]] == [
                    f"{2 * paper:,}",
                    f"{1.8 * paper:,.0f} – {2.2 * paper:,.0f}",
                    "500 periods",
                    f"paper {paper:,}",
                    "ratio 2.00",
                    "failures 2% †",
                ]


@pytest.mark.parametrize(
    ("failed", "top", "remark"),
    [(0.0, 1.0, ""), (0.0, 3.0, "†"), (0.004, 1.0, "failures <1%"), (1.0, 50.0, "failures 100% †")],
)
def test_failures_and_heavy_tails_are_remarked(failed: float, top: float, remark: str, pictured):
    axis = pictured(full(range(100, 112)).assign(failed_periods=failed, top_percent=top)).axes[0]
    assert {cell[-1].get_text().strip() for cell in texts(axis).values()} == {remark}


@pytest.mark.parametrize("periods", [2, 20, 33, 500])
def test_equal_periods_are_no_heavy_tail_however_few(periods: int, pictured):
    compared = compare_with_published(100.0, np.full(periods, 100.0), np.zeros(periods, bool))
    cells = made_up(**compared)
    assert not [text for axis in pictured(cells).axes for text in axis.texts if "†" in text.get_text()]


def test_equal_values_have_equal_colours_in_all_panels(pictured):
    figure = pictured(full([100, 200, 300, 400, 500, 600] * 2))
    np.testing.assert_array_equal(cell_colours(figure.axes[0]), cell_colours(figure.axes[1]))


def test_larger_is_darker(pictured):
    colours = cell_colours(pictured(full(np.geomspace(100, 1e6, 12))).axes[0]).reshape(-1, 3)
    grey = colours @ GREY
    assert (np.diff(grey) < 0).all()


@pytest.mark.parametrize("seen", [to_rgb, in_grey], ids=["in colour", "in grey"])
def test_every_text_stands_out_from_its_cell(seen, pictured):
    # Enough cells to meet every shade; the middle ones are the hardest.
    for low, high in ((1e2, 1e6), (1e3, 4e3)):
        figure = pictured(full(np.geomspace(low, high, 12)))
        for axis in figure.axes[:2]:
            colours = cell_colours(axis)
            assert len(texts(axis)) == 6
            for cell, written in texts(axis).items():
                for text in written:
                    assert contrast(seen(text.get_color()), seen(colours[cell])) >= 3


def test_every_text_fits_into_its_cell(pictured):
    figure = pictured(full(np.geomspace(2_000, 400_000, 12)))
    figure.canvas.draw()
    for axis in figure.axes[:2]:
        for (row, column), written in texts(axis).items():
            cell = axis.transData.transform([(column, row), (column + 1, row + 1)])
            (left, right), (below, above) = sorted(cell[:, 0]), sorted(cell[:, 1])
            boxes = [text.get_window_extent() for text in written if text.get_text().strip()]
            assert len(boxes) > 1
            assert all(left <= box.x0 and box.x1 <= right and below <= box.y0 and box.y1 <= above for box in boxes)
            assert not [one for one in boxes for other in boxes if one is not other and one.overlaps(other)]


def test_missing_cells_are_hatched_and_show_the_paper_only(pictured, small: Small):
    figure = pictured(small.table.frames(Runs.of_study(small.study, small.reader))[MAIN])
    for axis, panel in zip(figure.axes[: len(PUBLISHED)], PUBLISHED, strict=True):
        hatched = {
            (int(patch.get_y()), int(patch.get_x()))
            for patch in axis.patches
            if patch.get_hatch() and patch.get_visible()
        }
        expected = {((4, 5).index(size), goals - 1) for name, size, goals in MISSING if name == panel}
        assert hatched == expected
        for row, column in expected:
            (note,) = texts(axis)[row, column]
            assert note.get_text() == f"not measured\npaper {PUBLISHED[panel][(4, 5)[row]][column + 1]:,}"
            assert contrast(note.get_color(), note.get_bbox_patch().get_facecolor()[:3]) >= 3


def test_a_table_without_any_measured_cell_is_hatched_everywhere(pictured, small: Small):
    figure = pictured(made_up())
    assert [sum(bool(patch.get_hatch()) for patch in axis.patches) for axis in figure.axes[:2]] == [6, 6]
    assert small.table.text({MAIN: made_up()})[0].count("| missing") == 12


@pytest.mark.parametrize("measured", [[500.0] * 12, [np.nan] * 11 + [500.0]], ids=["all equal", "only one"])
def test_a_single_value_can_be_drawn(measured: list[float], pictured, recwarn: pytest.WarningsRecorder):
    figure = pictured(full(measured))
    assert "500" in {text.get_text() for text in figure.axes[1].texts}
    assert list(recwarn) == []


def test_one_period_shows_no_interval(pictured, small: Small):
    cells = full(range(100, 112)).assign(ci_low=np.nan, ci_high=np.nan)
    figure = pictured(cells)
    assert not [text for axis in figure.axes for text in axis.texts if "nan" in text.get_text()]
    assert "nan" not in "".join(small.table.text({MAIN: cells}))


def test_sizes_that_are_lists_can_be_drawn(small: Small):
    # A world of [4, 5] has no single number for a size.
    table = replace(small.table, published={"ad_hoc": {"[4, 5]": {1: 100.0}}})
    cells = full(range(100, 112)).head(1).assign(size="[4, 5]")
    figure = table.draw({MAIN: cells})
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == ["[4, 5]"]
    mpl.pyplot.close(figure)
