"""The UI command with a real MLflow server, and the saved views in a real browser."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rl_design_space.commands.words.ui import main, show
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.tracking.tracker import SweepEnding
from rl_design_space.tracking.ui_server import serving
from tests.browser import needs_browser
from tests.commands.ui_command import free_port, ui_of
from tests.devtools import Tab, tab
from tests.tracking.stores import copy_database, import_mlflow, learned, tracker_at

#: Overrides of the points of two studies.
STUDIES = {"mine": ("representation=ad_hoc", "representation=direction"), "yours": ("exploration=linear",)}


@pytest.fixture(scope="module")
def outputs(empty_database: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Create a store with points of two studies and the sweep that ran them."""
    import_mlflow()
    folder = tmp_path_factory.mktemp("ui") / "out"
    folder.mkdir()
    copy_database(empty_database, folder / "mlflow.db")
    tracker = tracker_at(folder / "mlflow.db")
    results = [
        (replace(planned, studies=(study,)), curves)
        for study, overrides in STUDIES.items()
        for planned, curves in map(learned, overrides)
    ]
    plan = Plan([planned for planned, _ in results], studies=tuple(STUDIES)).named()
    sweep = tracker.open_sweep(plan, "rl-design-space study=mine,yours")
    for planned, (_, curves) in zip(plan, results, strict=True):
        tracker.record(planned, curves)
    stored = tracker.finished([planned.fingerprint for planned in plan])
    sweep.close(SweepEnding("FINISHED", "3 learned now", {"done": len(plan), "failed": 0}, {}, stored))
    return folder


@pytest.fixture(scope="module")
def served(outputs: Path) -> Iterator[dict[str, str]]:
    """Run the command, and return the links that it prints."""
    (outputs.parent / "temporary").mkdir()
    with ui_of(outputs.parent, "out") as links:
        yield links
    assert sorted(path.name for path in outputs.parent.iterdir()) == ["out", "temporary"]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tab]:
    with tab(tmp_path_factory.mktemp("profile")) as opened:
        # Columns that do not fit are not rendered, and the assistant takes a third of the page.
        opened.size(2400, 1600)
        opened.before_each_page("localStorage.setItem('mlflow.assistant.fab.autoOpenedOnFirstLoad_v1', 'true')")
        yield opened


def test_the_command_prints_every_link(served: dict[str, str]):
    assert list(served)[1:] == ["all design points", "study mine", "study yours", "all sweeps"]
    assert "viewStateShareKey=study.mine&" in served["study mine"]
    assert next(iter(served)) == f"MLflow's UI at {served['study mine']}"


def headings(page: Tab) -> list[str]:
    """Return the headings of the table, from left to right."""
    found: list[str] = page.evaluate(
        "[...document.querySelectorAll('[data-testid^=sort-header]')]"
        ".sort((one, other) => one.getBoundingClientRect().x - other.getBoundingClientRect().x)"
        ".map(heading => heading.innerText)"
    )
    return found


@needs_browser
def test_the_table_of_a_study_shows_axes_and_results(served: dict[str, str], page: Tab):
    page.open(served["study mine"])
    page.wait("document.querySelectorAll('.ag-center-cols-container .ag-row').length == 2")
    page.wait("document.querySelector('[data-testid=\"sort-header-final_steps_over_optimum\"]')")
    assert headings(page) == [
        *("Run Name", "Created", "representation", "task.periods"),
        *("total_steps", "failed_trials", "final_steps_over_optimum", "Duration"),
    ]
    says = page.text()
    assert "2 matching runs" in says
    assert re.search(r"ad_hoc\s+3\s", says)
    assert re.search(r"direction\s+3\s", says)


DRAWN = {"ad_hoc constant": 4, "direction constant": 4}


def plots(kind: str) -> str:
    """Return JavaScript that selects the plots whose traces all have one type."""
    return (
        "[...document.querySelectorAll('.js-plotly-plot')]"
        f".filter(plot => plot.data?.length && plot.data.every(line => line.type == '{kind}'))"
    )


@needs_browser
def test_the_charts_of_a_study_are_its_learning_curves(served: dict[str, str], page: Tab):
    page.open(f"{served['study mine']}&compareRunsMode=CHART")
    page.wait(f"{plots('scatter')}.length == 3 && {plots('bar')}.length == 3")
    lines = page.evaluate(f"{plots('scatter')}.map(plot => plot.data.map(line => [line.name, line.x.length]))")
    # One line per run, with its 4 trials.
    assert all(dict(plot) == DRAWN for plot in lines)
    says = page.text()
    titles = ["Learning curves", "steps/mean", "steps/median", "success_rate"]
    totals = ["Totals", "total_steps", "failed_trials", "final_steps_over_optimum", "Choices"]
    places = [says.find(f"\n{title}\n") for title in (*titles, *totals)]
    assert -1 not in places
    assert places == sorted(places)
    assert "env_steps_per_second" not in says


@needs_browser
def test_the_views_are_in_the_menu(served: dict[str, str], page: Tab):
    page.open(served["all design points"])
    page.wait("document.querySelectorAll('.ag-center-cols-container .ag-row').length == 3")
    assert headings(page)[2:6] == ["representation", "exploration", "msa", "reward"]
    assert "all design points" in page.text()


@needs_browser
def test_the_table_of_sweeps_shows_their_counts(served: dict[str, str], page: Tab):
    page.open(served["all sweeps"])
    page.wait("document.querySelector('[data-testid=\"sort-header-points/failed\"]')")
    assert "**mine,yours**: 3 points (not all combinations of" in page.text()


#: The pictures of the description of a run that are drawn, not broken.
PICTURES = "[...document.querySelectorAll('img[src*=get-artifact]')].filter(picture => picture.naturalWidth > 100)"


@needs_browser
@pytest.mark.parametrize(("link", "says"), [("study mine", "steps in 4 trials"), ("all sweeps", "3 learned now")])
def test_the_page_of_a_run_shows_its_picture(link: str, says: str, served: dict[str, str], page: Tab):
    page.open(served[link])
    page.wait("document.querySelector('.ag-row a[href*=\"/runs/\"]')")
    page.evaluate("document.querySelector('.ag-row a[href*=\"/runs/\"]').click()")
    page.wait(f"{PICTURES}.length == 1")
    assert says in page.text()


def test_links_to_a_tracking_server_are_printed(
    served: dict[str, str], outputs: Path, capsys: pytest.CaptureFixture[str]
):
    address = served["study mine"].partition("/#")[0]
    show([f"tracking.uri={address}", "study=yours"], port=5000)
    first, *links = capsys.readouterr().out.splitlines()
    assert first == f"MLflow's UI at {served['study yours']}"
    assert dict(re.split(r"\s{2,}", line) for line in links) == dict(list(served.items())[1:])


def test_a_port_in_use_is_an_error(served: dict[str, str], outputs: Path):
    port = served["study mine"].partition("/#")[0].rpartition(":")[2]
    with pytest.raises(ConfigError, match=rf"--port {port}: cannot be used \(Address already in use\); give another"):
        main([f"outputs={outputs}", "--port", port])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["outputs={}/nowhere"], "no run has been recorded there yet"),
        (["outputs={}", "study=theirs"], r"study=theirs: no sweep of it is recorded here \(there is mine, yours\)"),
        (["tracking=none"], "nothing is recorded, so there is no store"),
        (["world.size=4"], "not a setting"),
        (["outputs={}", "tracking.experiment=elsewhere"], "there is no such experiment"),
        (["outputs={}", "--port", "70000"], "not a valid port number"),
    ],
)
def test_invalid_arguments_are_refused(words: list[str], message: str, outputs: Path):
    with pytest.raises(ConfigError, match=message):
        main([word.format(outputs) for word in words])
    assert not (outputs / "nowhere").exists()


def test_a_server_that_does_not_start_is_explained(tmp_path: Path):
    server = serving("nonsense://store", free_port(), tmp_path / "artifacts")
    with pytest.raises(ConfigError, match=r"did not start; the end of its log:\n(.*\n)*.*nonsense"):
        server.__enter__()
