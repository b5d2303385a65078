"""Draw the rooms of the package and the imports between them: `python -m docs.rooms`.

The rooms and their order are those of the layers contract in pyproject.toml, the imports those that import-linter
checks. Writes docs/images/rooms.png, the same bytes for the same code; needs what the tests need.
"""

from __future__ import annotations

import tomllib
from itertools import accumulate, pairwise
from pathlib import Path
from textwrap import fill

import grimp
import matplotlib as mpl
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch, Polygon

_ROOT = Path(__file__).parents[1]
_PICTURE = Path(__file__).parent / "images" / "rooms.png"
_PACKAGE = "rl_design_space"

#: Points: from one box to the next, half the size of a box, and the margin around all.
_RIGHT, _DOWN = 71, 58
_HALF_WIDTH, _HALF_HEIGHT = 42, 23
#: Number of names from which on they are written smaller.
_MANY = 9
_MARGIN = 6
#: Points: the width of an arrow for each import, the thinnest arrow, the space between two, the size of a head.
_AN_IMPORT, _THINNEST, _GAP, _HEAD = 0.26, 1.0, 1.6, (1.7, 6)
_INK = "#1b1f24"
_CENTRED = {"ha": "center", "va": "center", "color": _INK}

_Spot = tuple[float, float]
_Colour = tuple[float, ...]


def rooms() -> pd.DataFrame:
    """Return the rooms from top to bottom: one row a folder, and one for neighbouring layers of single modules.

    Returns:
        Columns `modules` (their names below the package) and `lines` (of Python). The package's own `__init__` belongs
        to the top room, because the public names come from the rooms below.
    """
    settings = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (contract,) = (each for each in settings["contracts"] if each["type"] == "layers")
    layers = [("__init__",)]
    for layer in contract["layers"]:
        modules = tuple(layer.split(" | "))
        if any(map(_is_folder, (*layers[-1], *modules))):
            layers.append(modules)
        else:
            layers[-1] += modules
    return pd.DataFrame({"modules": layers, "lines": [sum(map(_lines, modules)) for modules in layers]})


def imports(layers: pd.DataFrame) -> pd.DataFrame:
    """Return the direct imports between rooms, those inside functions and for types included.

    Args:
        layers: as `rooms` returns them.

    Returns:
        One row a pair of rooms: `importer` and `imported` (rows of `layers`), and `imports` (pairs of modules).
    """
    room_of = {module: room for room, modules in layers["modules"].items() for module in modules}
    graph = grimp.build_graph(_PACKAGE, cache_dir=None)
    pairs = [
        (room_of[_part(importer)], room_of[_part(imported)])
        for importer in graph.modules
        for imported in graph.find_modules_directly_imported_by(importer)
    ]
    frame = pd.DataFrame(pairs, columns=["importer", "imported"])
    between = frame[frame["importer"] != frame["imported"]]
    return between.value_counts(sort=False).rename("imports").reset_index().sort_values(["importer", "imported"])


def draw(layers: pd.DataFrame, edges: pd.DataFrame, picture: Path) -> None:
    """Draw a staircase: an arrow leaves its importer to the right, turns once, and ends on top of the imported room.

    Args:
        layers: as `rooms` returns them.
        edges: as `imports` returns them.
        picture: the PNG to write.
    """
    edges = edges.assign(width=edges["imports"].map(_width))
    # Near rooms are reached by the lowest lane, and from near rooms by the leftmost: so no two lanes of a room cross.
    leaves = _lanes(edges.sort_values("imported"), "importer")
    enters = _lanes(edges.sort_values("importer", ascending=False), "imported")
    steps = len(layers) - 1
    width = steps * _RIGHT + 2 * (_HALF_WIDTH + _MARGIN)
    height = steps * _DOWN + 2 * (_HALF_HEIGHT + _MARGIN)
    figure = plt.figure(figsize=(width / 72, height / 72))
    axis = figure.add_axes((0, 0, 1, 1))
    left, top = -_HALF_WIDTH - _MARGIN, _HALF_HEIGHT + _MARGIN
    axis.set(xlim=(left, left + width), ylim=(top - height, top))
    axis.set_axis_off()
    # From top to bottom dark to light, in an order that also holds without colours.
    colours = [mpl.colormaps["viridis"](0.8 * room / steps) for room in layers.index]
    for edge in edges.sort_values("importer").itertuples():
        start = (edge.importer * _RIGHT + _HALF_WIDTH, leaves[edge.Index] - edge.importer * _DOWN)
        end = (edge.imported * _RIGHT + enters[edge.Index], _HALF_HEIGHT - edge.imported * _DOWN)
        _arrow(axis, start, end, edge.width, colours[edge.importer])
    for room, modules, lines in layers.itertuples():
        _box(axis, (room * _RIGHT, -room * _DOWN), modules, lines, colours[room])
    _key(axis, left + _MARGIN, top - height + _MARGIN)
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=150, metadata={"Software": None})
    plt.close(figure)


def main() -> None:
    """Read the imports and draw them."""
    layers = rooms()
    with plt.style.context("default"):
        draw(layers, imports(layers), _PICTURE)
    print(_PICTURE.relative_to(_ROOT))


def _part(module: str) -> str:
    """Return the first part of a module's name below the package."""
    return module.split(".")[1] if "." in module else "__init__"


def _is_folder(module: str) -> bool:
    return (_ROOT / _PACKAGE / module).is_dir()


def _lines(module: str) -> int:
    path = _ROOT / _PACKAGE / module
    files = path.rglob("*.py") if _is_folder(module) else [path.with_suffix(".py")]
    return sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


def _width(count: int) -> float:
    return max(_THINNEST, _AN_IMPORT * count)


def _lanes(edges: pd.DataFrame, side: str) -> dict[int, float]:
    """Return where each edge lies in the bundle at its room, in points from the middle, in the order of the edges."""
    lanes = {}
    for _, bundle in edges.groupby(side, sort=False):
        ends = list(accumulate(bundle["width"] + _GAP, initial=0))
        middles = [(first + last - ends[-1]) / 2 for first, last in pairwise(ends)]
        lanes.update(zip(bundle.index, middles, strict=True))
    return lanes


def _arrow(axis: Axes, start: _Spot, end: _Spot, width: float, colour: _Colour) -> None:
    """Draw an arrow that turns once, of a width in points, with a white rim where it crosses others."""
    (x, y), (to_x, to_y) = start, end
    wing, length = _HEAD
    for rim, paint in ((0.7, "white"), (0.0, colour)):
        half, beyond = width / 2 + rim, width / 2 + wing
        shaft = [(x, y + half), (to_x + half, y + half), (to_x + half, to_y + length)]
        head = [(to_x + beyond, to_y + length), (to_x, to_y), (to_x - beyond, to_y + length)]
        back = [(to_x - half, to_y + length), (to_x - half, y - half), (x, y - half)]
        axis.add_patch(Polygon(shaft + head + back, facecolor=paint, linewidth=0))


def _box(axis: Axes, middle: _Spot, modules: tuple[str, ...], lines: int, colour: _Colour) -> None:
    """Draw a room with its number of lines, to two digits; the modules of a room without a folder are listed."""
    x, y = middle
    corner, sides = (x - _HALF_WIDTH, y - _HALF_HEIGHT), (2 * _HALF_WIDTH, 2 * _HALF_HEIGHT)
    frame = FancyBboxPatch(
        corner, *sides, "round,pad=0,rounding_size=5", facecolor="white", edgecolor=colour, linewidth=2
    )
    axis.add_patch(frame)
    if len(modules) == 1:
        axis.text(x, y + 5, modules[0], fontsize=12.5, weight="bold", **_CENTRED)
    else:
        width, size = (28, 5) if len(modules) >= _MANY else (18, 7)
        axis.text(x, y + 6, fill("  ".join(modules), width), fontsize=size, weight="bold", linespacing=1.05, **_CENTRED)
    axis.text(x, y - 13, f"{float(f'{lines:.2g}'):,.0f} lines", fontsize=8.5, **_CENTRED)


def _key(axis: Axes, left: float, bottom: float) -> None:
    """Explain arrows and widths in the corner that the staircase leaves free."""
    axis.text(left, bottom + 62, "An arrow leads from a room to one that it imports.", fontsize=11, color=_INK)
    axis.text(left, bottom + 44, "Its width is the number of imports, module by module:", fontsize=11, color=_INK)
    for place, count in enumerate((1, 10, 25)):
        x = left + place * 70
        _arrow(axis, (x, bottom + 28), (x + 30, bottom + 4), _width(count), mpl.colormaps["viridis"](0.3))
        axis.text(x + 40, bottom + 14, str(count), fontsize=11, color=_INK, va="center")


if __name__ == "__main__":
    main()
