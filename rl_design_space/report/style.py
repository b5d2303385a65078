"""The style of all reports: colours, axes, the format of numbers, and how pictures are saved."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from contextlib import ContextDecorator, suppress
from io import StringIO
from itertools import cycle, islice
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullFormatter, NullLocator
from matplotlib.transforms import ScaledTranslation

from rl_design_space._arrays import FloatArray
from rl_design_space.report.beside import beside

#: Colours that can be told apart by colour-blind readers (Okabe and Ito).
BLUE, VERMILION, ORANGE, GREEN = "#0072b2", "#d55e00", "#e69f00", "#009e73"
DARK_BLUE, FRAME, LIGHT_GREEN, GREY = "#1f4e79", "#e07b00", "#c7e0c7", "#555555"
#: The palette of that name in seaborn.
_COLORBLIND = (
    "#0173b2", "#de8f05", "#029e73", "#d55e00", "#cc78bc", "#ca9161", "#fbafe4", "#949494", "#ece133", "#56b4e9",
)  # fmt: skip
#: Lines and points that can be told apart without colours.
DASHES: list[Any] = ["-", (0, (5, 1)), (0, (3, 1, 1, 1)), (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2))]
MARKERS = "osD^vP"
#: Ratio of the largest to the least value from which on an axis or a colour scale is logarithmic.
DECADE = 10
#: Ticks of an axis of ratios, from the fewest to the most; the fewest of those with so many are taken.
_RATIOS = [
    *([one * 10.0**ten for ten in range(-9, 9) for one in ones] for ones in ((1, 2, 5), (1, 1.5, 2, 3, 5, 7))),
    *([part / parts for part in range(1, 20 * parts)] for parts in (5, 10, 20, 50, 100)),
]  # fmt: skip
_TICKS = 3
#: With a fixed salt the same figure is the same bytes; text in an SVG stays text.
#: Text is shown as it is: a dollar sign in a name begins no formula. Fonts in a PDF are TrueType (Type 42), which
#: publishers ask for.
_SETTINGS = {
    "svg.hashsalt": "rl-design-space", "svg.fonttype": "none", "pdf.fonttype": 42, "text.parse_math": False,
}  # fmt: skip
#: Looks of the note in the corner of a picture.
_MARK = {"fontsize": 8, "color": "#664d03", "backgroundcolor": "#fff3cd"}
#: Resolution of pictures.
DOTS_PER_INCH = 160
#: Resolution of pictures whose size was asked for: they are printed.
PRINTED = 300
#: What Matplotlib calls a line without a name.
_UNNAMED = re.compile(r"_child\d+")


def styled(font_size: float = 9) -> ContextDecorator:
    """Return a decorator of functions that draw: they draw in the style of all reports."""
    settings: dict[Any, Any] = {**_SETTINGS, "font.size": font_size}
    return mpl.rc_context(settings)


def colours(number: int, palette: str = "colorblind") -> Sequence[Any]:
    """Return so many colours of a palette of seaborn."""
    if palette == "colorblind":
        return list(islice(cycle(map(to_rgb, _COLORBLIND)), number))
    import seaborn as sns  # which takes a second and a half

    found: Sequence[Any] = sns.color_palette(palette, number)
    return found


def tidy(axis: Axes) -> None:
    """Draw a light grid behind the data, and no frame above and on the right."""
    axis.set_axisbelow(True)
    axis.grid(color="0.92")
    axis.spines[["top", "right"]].set_visible(False)


def make_logarithmic(axis: Axes) -> None:
    """Make the y-axis logarithmic, with plain numbers at 1, 2 and 5 of every decade."""
    axis.set_yscale("log")
    axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    write_in_full(axis.yaxis)
    axis.yaxis.set_minor_formatter(NullFormatter())


def show_ratios(axis: Axis, least: float, most: float) -> None:
    """Make an axis one of ratios: logarithmic, so that twice as much is as far from 1 as half as much."""
    axis._set_axes_scale("log")  # type: ignore[attr-defined]
    inside = [[tick for tick in ticks if least <= tick <= most] for ticks in _RATIOS]
    axis.set_major_locator(FixedLocator(next((ticks for ticks in inside if len(ticks) >= _TICKS), inside[-1])))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"×{value:.3g}"))
    axis.set_minor_locator(NullLocator())


def draw_curve(axis: Axes, curve: pd.DataFrame, colour: Any, dashes: Any, label: str | None = None) -> None:
    """Draw a learning curve in its band; `curve` has trial, mean, ci_low and ci_high."""
    axis.fill_between(curve["trial"], curve["ci_low"], curve["ci_high"], color=colour, alpha=0.25, linewidth=0)
    axis.plot(curve["trial"], curve["mean"], color=colour, linestyle=dashes, linewidth=1.4, label=label)


def beyond(low: pd.Series[float], value: pd.Series[float], high: pd.Series[float]) -> FloatArray:
    """Return how far intervals reach below and above their values, (2, values), not negative, for error bars."""
    reach: FloatArray = np.maximum(np.nan_to_num([value - low, high - value]), 0)
    return reach


def write_in_full(axis: Axis) -> None:
    """Write the numbers of an axis in full, not as powers of ten."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))


def legend_beside(axis: Axes, handles: Sequence[Any] | None = None) -> None:
    """Draw a legend on the right of an axis, where it hides no data."""
    if handles is None:  # by itself, Matplotlib leaves out all names that begin with an underscore
        handles = [line for line in axis.get_lines() if not _UNNAMED.fullmatch(str(line.get_label()))]
    axis.legend(handles=handles, frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1))


def share_limits(axes: Sequence[Axes]) -> None:
    """Give axes one above the other the same limits, which those side by side share."""
    limits = [axis.get_ylim() for axis in axes]
    for axis in axes:
        axis.set_ylim(min(low for low, _ in limits), max(high for _, high in limits))


def number(value: float, form: str = "") -> str:
    """Return a measured number as text; one that is rounded to zero has no sign.

    Args:
        value: the number.
        form: its format, without a sign; three significant digits, and all digits before the point, if empty.
    """
    return f"{value:z{form}}" if form else f"{value:,.0f}" if abs(value) >= 1000 else f"{value:z.3g}"


def interval(low: float, high: float, form: str = "") -> str:
    """Return an interval as text, its ends as `number` writes them; empty text if there is none (NaN)."""
    return "" if math.isnan(low) else f"{number(low, form)} – {number(high, form)}"


@styled()
def add_mark(figure: Figure, mark: str) -> None:
    """Write a short note into the upper right corner of a figure; nothing if it is empty."""
    if mark:
        place = figure.transFigure + ScaledTranslation(-0.08, -0.08, figure.dpi_scale_trans)  # inches
        figure.text(1, 1, mark, ha="right", va="top", transform=place, **_MARK)  # type: ignore[arg-type]


@styled()
def save(figure: Figure, stem: Path, dots_per_inch: float = DOTS_PER_INCH, *, pdf: bool = False) -> list[Path]:
    """Write a figure as PNG and SVG, and as PDF if asked for, the same bytes for the same figure, and close it.

    Args:
        figure: to be written.
        stem: path of the files without their suffix.
        dots_per_inch: resolution of the PNG.
        pdf: whether a PDF is written, too.

    Returns:
        The paths written.
    """
    png, svg = (stem.with_name(f"{stem.name}{suffix}") for suffix in (".png", ".svg"))
    figure.set_dpi(dots_per_inch)
    # The canvases, because `Figure.savefig` draws everything once more before each file.
    canvas = FigureCanvasAgg(figure)
    if layout := figure.get_layout_engine():
        with suppress(ValueError):  # as in `Figure.draw`
            layout.execute(figure)
        figure.set_layout_engine("none")  # the places of all parts are known now; to find them takes as long as to draw
    as_svg = beside(lambda: _as_svg(figure))
    canvas.print_png(png)  # type: ignore[no-untyped-call]
    svg.write_bytes(as_svg())
    paths = [png, svg]
    if pdf:
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        paths.append(stem.with_name(f"{stem.name}.pdf"))
        FigureCanvasPdf(figure).print_pdf(paths[-1], metadata={"CreationDate": None})  # type: ignore[no-untyped-call]
    plt.close(figure)
    return paths


def _as_svg(figure: Figure) -> bytes:
    """Return a figure as SVG; a copy of the process writes no file, which might appear after an interrupt."""
    content = StringIO()
    FigureCanvasSVG(figure).print_svg(content, metadata={"Date": None})  # type: ignore[no-untyped-call]
    return content.getvalue().encode()
