"""The page to explore runs: its data, and in a real browser its views, clicks, filters and address."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from rl_design_space.commands import figure_words
from rl_design_space.errors import ConfigError
from rl_design_space.report.explore import page_data, render
from rl_design_space.report.look import Look
from tests.browser import needs_browser
from tests.devtools import Tab, tab
from tests.tracking.stores import copy_database, learned, record, tracker_at

needs_plotly = pytest.mark.skipif(find_spec("plotly") is None, reason="needs Plotly (the extra explore)")

ADDRESS = "http://127.0.0.1:5000/#/experiments/1/runs/RUN_ID"


def frame() -> pd.DataFrame:
    """Return 12 runs of two representations, three slopes and two seeds; the last has no number."""
    rows = [
        {"representation": name, "exploration.k": k, "seed": seed, "total_steps": 1000.0 * place + 100 * k + seed}
        for place, name in enumerate(("ad_hoc", "<direction>"), 1)
        for k in (1, 2, 10)
        for seed in (0, 1)
    ]
    made = pd.DataFrame(rows, index=pd.Index([f"{number:032x}" for number in range(12)], name="run_id"))
    made.loc[made.index[-1], "total_steps"] = np.nan
    made["world.size"], made["artifacts"], made["fingerprint"] = 10, "there", made.index
    made["name"] = [f"exploration.k={row['exploration.k']} msa.lengths=[2, 3]" for row in rows]
    return made


def curves() -> dict[str, list[np.ndarray]]:
    return {"steps/mean": [np.linspace(100 + run, 10, 5 if run else 3) for run in range(12)]}


def test_the_data_are_those_of_the_frame():
    data = page_data(frame(), ["total_steps"], curves(), ADDRESS)
    names = {parameter["name"]: parameter for parameter in data["parameters"]}
    assert list(names) == ["representation", "exploration.k", "seed"]
    assert names["exploration.k"]["values"] == ["1", "2", "10"]
    assert names["exploration.k"]["index"] == [0, 0, 1, 1, 2, 2] * 2
    assert data["fixed"] == {"world.size": "10"}
    (number,) = data["numbers"]
    assert number["values"][:2] == [1100.0, 1101.0]
    assert number["values"][-1] is None
    assert data["runs"]["commands"][0] == "rl-design-space exploration.k=1 'msa.lengths=[2, 3]'"
    (curve,) = data["curves"]
    assert curve["trials"] == 5


def test_the_words_of_the_command_are_checked(tmp_path: Path, empty_database: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    record(tracker_at(tmp_path / "mlflow.db"), *learned())
    with pytest.raises(ConfigError, match=r"steps/men.*steps/mean"):
        figure_words.main("explore", ["--curves", "steps/men", f"outputs={tmp_path}"])
    with pytest.raises(ConfigError, match="steps_befor"):
        figure_words.main("explore", ["--values", "steps_befor=3", f"outputs={tmp_path}"])


@needs_plotly
def test_recorded_runs_become_a_page(tmp_path: Path, empty_database: Path):
    copy_database(empty_database, tmp_path / "mlflow.db")
    tracker = tracker_at(tmp_path / "mlflow.db")
    runs = [record(tracker, *learned(f"seed={seed}")) for seed in (0, 1)]
    (page,) = figure_words.main("explore", ["--values", "steps_after=2", f"outputs={tmp_path}"])
    html = page.read_text(encoding="utf-8")
    assert page == tmp_path / "report" / "explore.html"
    assert all(run.run_id in html for run in runs)
    assert '"steps_after=2"' in html
    assert not re.search(r'<(?:script|link|img)[^>]* (?:src|href)="(?!data:)', html)
    assert "default-src 'none'" in html


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Tab, str]]:
    """The page of the frame in a browser, and its address."""
    folder = tmp_path_factory.mktemp("explore")
    path = folder / "explore.html"
    path.write_text(render(page_data(frame(), ["total_steps"], curves(), ADDRESS), "Runs", "made"), encoding="utf-8")
    with tab(folder / "profile") as opened:
        opened.size(1200, 1600)
        yield opened, path.as_uri()


def shown(opened: Tab, address: str) -> None:
    opened.open(address)
    opened.wait("document.querySelector('#table button') && document.querySelector('#chart .main-svg')")


def choose(opened: Tab, name: str, value: str) -> None:
    """Choose an option as a user does: its change is an event."""
    opened.evaluate(
        f"(() => {{ const select = document.querySelector('[name={name}]'); select.value = '{value}';"
        "select.dispatchEvent(new Event('change', { bubbles: true })); })()"
    )


def click(opened: Tab, selector: str, across: float = 0.5, down: float = 0.5) -> None:
    """Click with the mouse into an element."""
    x, y = opened.evaluate(
        f"(() => {{ const box = document.querySelector({selector!r}).getBoundingClientRect();"
        f"return [box.left + {across} * box.width, box.top + {down} * box.height]; }})()"
    )
    opened.click(x, y)


def status(opened: Tab) -> str:
    return str(opened.evaluate("document.getElementById('status').textContent"))


@needs_plotly
@needs_browser
def test_a_click_on_a_cell_shows_its_runs(page: tuple[Tab, str]):
    opened, address = page
    shown(opened, address)
    assert status(opened) == "6 cells with runs, mean of the runs of a cell, 12 of 12 runs"
    cells = "[...document.querySelectorAll('#table td button')].map((cell) => cell.textContent)"
    assert opened.evaluate(cells) == ["2,101", "2,201", "3,000", "1,101", "1,201", "2,001"]
    opened.wait("document.querySelector('#chart .heatmaplayer image') !== null")
    click(opened, "#chart .nsewdrag", 0.5, 0.75)
    opened.wait("!document.getElementById('chosen').hidden")
    text = opened.evaluate("document.getElementById('chosen').innerText")
    assert "representation=ad_hoc exploration.k=2: 2 runs" in text
    assert text.count("rl-design-space exploration.k=2 'msa.lengths=[2, 3]'") == 2
    link = opened.evaluate("document.querySelector('#chosen a').href")
    assert link == ADDRESS.replace("RUN_ID", f"{2:032x}")
    opened.wait("document.querySelectorAll('#chosen-chart .scatterlayer .trace').length == 2")
    # Of a picture, screen readers read its buttons alone; each has a name of its own, and none sends data elsewhere.
    opened.wait("[...document.querySelectorAll('#chosen-chart svg')].every((drawn) => drawn.ariaHidden === 'true')")
    assert opened.evaluate("document.querySelectorAll('#chart svg:not([aria-hidden=true])').length") == 0
    assert opened.evaluate("document.querySelectorAll('[role=img] button').length") == 0
    names = "[...document.querySelectorAll('main button, main a')].map((each) => each.ariaLabel ?? each.textContent)"
    named = [name for name in opened.evaluate(names) if name.startswith(("MLflow", "Copy"))]
    assert named == [
        f"MLflow run {2:032x}"[:19], "Copy: rl-design-space exploration.k=2 'msa.lengths=[2, 3]'",
        f"MLflow run {3:032x}"[:19], "Copy: rl-design-space exploration.k=2 'msa.lengths=[2, 3]'",
    ]  # fmt: skip
    assert "Share" not in " ".join(opened.evaluate(names))


def test_labels_order_and_colours_are_those_that_were_chosen():
    look = Look(
        labels={"representation=ad_hoc": "Ad hoc"},
        order={"representation": "ad_hoc"},
        scale="log",
        colour_map="viridis",
    )
    data = page_data(frame(), ["total_steps"], curves(), ADDRESS, look)
    values = next(each["values"] for each in data["parameters"] if each["name"] == "representation")
    assert values == ["ad_hoc", "<direction>"]
    assert data["look"]["labels"] == {"representation=ad_hoc": "Ad hoc"}
    assert data["look"]["cells"][0] == [68, 1, 84]
    assert data["look"]["lines"][0].startswith("#")
    usual = page_data(frame(), ["total_steps"], curves(), ADDRESS)["look"]
    assert usual == {"labels": {}, "scale": "", "cells": [], "lines": []}


@needs_plotly
@needs_browser
def test_labels_are_what_is_read_and_names_what_is_linked(page: tuple[Tab, str], tmp_path: Path):
    opened, _ = page
    path = tmp_path / "labelled.html"
    look = Look(
        labels={"representation=ad_hoc": "Ad hoc", "exploration.k": "decay", "total_steps": "Total"}, scale="log"
    )
    data = page_data(frame(), ["total_steps"], curves(), ADDRESS, look)
    path.write_text(render(data, "Runs", "made"), encoding="utf-8")
    shown(opened, path.as_uri())
    assert (
        opened.evaluate("document.getElementById('chart-heading').textContent") == "Total by representation and decay"
    )
    button = "document.querySelector('#table button[data-key=\"representation=ad_hoc exploration.k=1\"]')"
    assert opened.evaluate(f"{button}.ariaLabel") == "Ad hoc, decay=1: 1,101, show its runs"
    opened.evaluate(f"{button}.click()")
    assert opened.evaluate("location.hash") == "#chosen=representation%3Dad_hoc+exploration.k%3D1"
    assert opened.evaluate("document.querySelector('[name=scale]').value") == "log"


@needs_plotly
@needs_browser
def test_the_address_shows_the_same_again(page: tuple[Tab, str]):
    opened, address = page
    shown(opened, address)
    choose(opened, "of", "max")
    choose(opened, "scale", "log")
    opened.evaluate("document.querySelector('#filters summary').click()")
    click(opened, "#filter-list input[data-parameter='exploration.k'][data-place='2']")
    assert status(opened) == "4 cells with runs, max of the runs of a cell, 8 of 12 runs"
    opened.evaluate("document.querySelector('#table td button').focus()")
    for kind in ("keyDown", "keyUp"):
        opened._call(
            "Input.dispatchKeyEvent", type=kind, key="Enter", code="Enter", text="\r", windowsVirtualKeyCode=13
        )
    opened.wait("!document.getElementById('chosen').hidden")
    assert opened.evaluate("document.activeElement.id") == "chosen-heading"
    before = opened.evaluate("location.href"), opened.evaluate("document.getElementById('table').innerText")
    shown(opened, before[0])
    opened.wait("!document.getElementById('chosen').hidden")
    assert (opened.evaluate("location.href"), opened.evaluate("document.getElementById('table').innerText")) == before
    opened.evaluate("document.getElementById('reset').click()")
    assert status(opened) == "6 cells with runs, mean of the runs of a cell, 12 of 12 runs"


@needs_plotly
@needs_browser
def test_every_view_draws_the_runs(page: tuple[Tab, str]):
    opened, address = page
    shown(opened, address)
    traces = "document.querySelectorAll('#chart .scatterlayer .trace').length"
    choose(opened, "view", "curves")
    opened.wait(f"{traces} == 2")
    assert status(opened).startswith("2 lines, mean of the runs of a line")
    choose(opened, "view", "scatter")
    opened.wait("document.querySelectorAll('#chart .scatterlayer .point').length == 11")
    choose(opened, "view", "parallel")
    opened.wait(f"{traces} == 11")
    assert "A line for each run" in status(opened)
    opened.evaluate("document.querySelector('#filters').open = true")
    for place in (0, 1):
        click(opened, f"#filter-list input[data-parameter='representation'][data-place='{place}']")
    assert status(opened) == "The filters leave out all runs"


@needs_plotly
@needs_browser
def test_nothing_is_wider_than_a_phone(page: tuple[Tab, str]):
    opened, address = page
    opened.size(390, 844)
    shown(opened, address)
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390
    assert opened.evaluate("document.querySelector('#chart .main-svg').getBoundingClientRect().width") <= 390
    opened.size(1200, 1600)
