"""Take the screenshots of docs/mlflow.md with Chromium: `python -m docs.screenshots`.

Runs a study of the paper in a temporary folder, starts `rl-design-space ui` there, opens the links that it prints, and
writes docs/images/mlflow-*.png. Takes a minute; needs what the tests need.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.command_runner import SCRIPTS, environment
from tests.commands.ui_command import ui_of
from tests.devtools import Tab, tab

_IMAGES = Path(__file__).parent / "images"
#: State of the UI in the browser: the assistant is closed and "Model training" chosen.
_SETTINGS = (
    "'mlflow.assistant.fab.autoOpenedOnFirstLoad_v1', 'true'",
    "'mlflow.workflowType_v1', '\"machine_learning\"'",
)
#: The picture of a description is drawn.
_PICTURE = "document.querySelector('img[src*=get-artifact]')?.naturalWidth > 100"
_ROWS = "document.querySelectorAll('.ag-center-cols-container .ag-row').length"


def main() -> None:
    """Run the study, serve it and take the screenshots."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "temporary").mkdir()
        # The UI shows the user's name.
        variables = environment(folder, LOGNAME="reader", USER="reader")
        command = [SCRIPTS / "rl-design-space", "study=fig2", "outputs=out"]
        subprocess.run(command, cwd=folder, env=variables, check=True)
        with ui_of(folder, "out") as links, tab(folder / "profile") as page:
            for setting in _SETTINGS:
                page.before_each_page(f"localStorage.setItem({setting})")
            _table(page, links["study fig2"])
            _charts(page, links["study fig2"])
            _run(page, links["study fig2"])
            _sweep(page, links["all sweeps"])


def _table(page: Tab, address: str) -> None:
    page.size(1520, 710)
    page.open(address)
    page.wait(f"{_ROWS} == 10")
    page.photograph(_IMAGES / "mlflow-table.png")


def _charts(page: Tab, address: str) -> None:
    page.size(1500, 1240)
    page.open(f"{address}&compareRunsMode=CHART")
    page.wait("[...document.querySelectorAll('.js-plotly-plot')].filter(plot => plot.data?.length).length >= 6")
    page.photograph(_IMAGES / "mlflow-charts.png")


def _run(page: Tab, address: str) -> None:
    page.size(1500, 620)
    page.open(address)
    page.wait(f"{_ROWS} == 10")
    page.evaluate("document.querySelector('.ag-row a[href*=\"/runs/\"]').click()")
    page.wait(_PICTURE)
    page.photograph(_IMAGES / "mlflow-run.png")


def _sweep(page: Tab, address: str) -> None:
    page.size(1500, 1090)
    page.open(address)
    page.wait(f"{_ROWS} == 1")
    page.evaluate("document.querySelector('.ag-row a[href*=\"/runs/\"]').click()")
    page.wait("document.body.innerText.includes('Fewest total_steps')")
    page.evaluate("[...document.querySelectorAll('button')].find(button => button.innerText == 'Show more').click()")
    page.wait("document.body.innerText.includes('Show less')")
    page.wait(_PICTURE)
    page.photograph(_IMAGES / "mlflow-sweep.png")


if __name__ == "__main__":
    main()
