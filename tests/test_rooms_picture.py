"""The picture of the rooms shows the imports of the code, and the page about them lists the same rooms."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest
from matplotlib.image import imread

from docs import rooms

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "rl_design_space"
PAGE = ROOT / "docs" / "how-it-is-built.md"

LAYERS = rooms.rooms()
EDGES = rooms.imports(LAYERS)


def test_every_part_of_the_package_is_in_one_room():
    shown = [module for modules in LAYERS["modules"] for module in modules]
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert sorted(shown) == sorted(folders | {path.stem for path in PACKAGE.glob("*.py")})


def test_all_lines_are_counted():
    files = [file for file in PACKAGE.rglob("*.py") if "_plugins" not in file.parts]
    assert LAYERS["lines"].sum() == sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)


def test_every_arrow_points_down():
    assert (EDGES["imported"] > EDGES["importer"]).all()


def test_arrows_are_the_imports_of_the_source_files():
    room_of = {module: room for room, modules in LAYERS["modules"].items() for module in modules}
    counted = Counter((room_of[one], room_of[other]) for one, other in map(rooms_between, imported_pairs()))
    drawn = {(edge.importer, edge.imported): edge.imports for edge in EDGES.itertuples()}
    assert drawn == {rooms: count for rooms, count in counted.items() if rooms[0] != rooms[1]}


def test_the_page_lists_these_rooms():
    rows = re.findall(r"^\| (`.*?) \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    listed = [tuple(name.rstrip("/") for name in re.findall(r"`(.+?)`", row)) for row in rows]
    assert listed == list(LAYERS["modules"])[::-1]


def test_the_picture_is_on_the_page_and_is_written(tmp_path: Path):
    assert "](images/rooms.png)" in PAGE.read_text(encoding="utf-8")
    pictures = [tmp_path / "one.png", tmp_path / "two.png"]
    for picture in pictures:
        rooms.draw(LAYERS, EDGES, picture)
    assert imread(pictures[0]).std() > 0.01
    assert pictures[0].read_bytes() == pictures[1].read_bytes()


def test_lanes_of_a_bundle_do_not_overlap():
    edges = pd.DataFrame({"importer": [0, 0, 0], "width": [1.0, 4.0, 2.0]})
    lanes = rooms._lanes(edges, "importer")
    assert lanes[1] - lanes[0] > (1.0 + 4.0) / 2
    assert lanes[2] - lanes[1] > (4.0 + 2.0) / 2
    assert lanes[0] - 0.5 == pytest.approx(-(lanes[2] + 1.0))


def imported_pairs() -> set[tuple[str, str]]:
    """Return importing and imported module of every import statement, by parsing the files."""
    names = {name_of(file) for file in PACKAGE.rglob("*.py")}
    pairs = set()
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                below = [f"{node.module}.{alias.name}" for alias in node.names]
                found = [name if name in names else node.module for name in below]
            else:
                continue
            pairs |= {(name_of(file), name) for name in found if name in names}
    return {(one, other) for one, other in pairs if "_plugins" not in one + other}


def name_of(file: Path) -> str:
    parts = file.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def rooms_between(pair: tuple[str, str]) -> tuple[str, str]:
    one, other = (f"{name}.__init__".split(".")[1] for name in pair)
    return one, other
