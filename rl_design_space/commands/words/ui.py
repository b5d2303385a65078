"""Open MLflow's UI on the recorded runs, with a view per study."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rl_design_space.commands.arguments import Parser
from rl_design_space.commands.messages import tell

if TYPE_CHECKING:
    from rl_design_space.tracking import MlflowTracking

_STUDY = "study="


def main(arguments: Sequence[str]) -> None:
    """Serve the UI until Ctrl-C or SIGTERM; if the store is a tracking server, print its links instead.

    Raises:
        ConfigError: nothing is recorded, the store cannot be used, or the port is in use.
    """
    parser = Parser(
        prog="rl-design-space ui",
        description="Open MLflow's UI on the recorded runs: all design points, all sweeps, and a view per study.",
        epilog="example: rl-design-space ui study=table4 outputs=outputs/quick --port 5001",
    )
    parser.add_argument(
        "overrides", nargs="*", help="study=NAME to begin with (default: the last one), and settings, e.g. outputs=DIR"
    )
    parser.add_argument("--browser", action="store_true", help="open the study in your browser")
    parser.add_argument("--port", type=int, default=5000, help="port of the UI on this machine (default: 5000)")
    given = parser.parse_intermixed_args(arguments)
    with suppress(KeyboardInterrupt):
        show(given.overrides, given.port, browser=given.browser)


def show(overrides: Sequence[str], port: int, *, browser: bool = False) -> None:
    """Serve the UI until it is interrupted; if the store is a tracking server, print its links instead.

    Args:
        overrides: the study to begin with, and settings, which select the store.
        port: port of the UI.
        browser: whether to open the study in a browser.

    Raises:
        ConfigError: nothing is recorded, the store cannot be used, or the port is in use.
        KeyboardInterrupt: raised after the server has stopped.
    """
    from rl_design_space.run.settings import settings_of, store_of

    named = [override for override in overrides if override.startswith(_STUDY)]
    study = named[-1].removeprefix(_STUDY) if named else None
    settings = [override for override in overrides if override not in named]
    with _writable(store_of(settings)) as tracking:
        _serve(tracking, port, Path(settings_of(settings).outputs) / "artifacts", study, browser)


@contextmanager
def _writable(tracking: MlflowTracking) -> Iterator[MlflowTracking]:
    """Replace a database that cannot be written to by a copy: MLflow's UI writes to it."""
    from rl_design_space.commands.terminal import console
    from rl_design_space.tracking.address import SQLITE, sqlite_path
    from rl_design_space.tracking.read_only import unwritable, writable_copy

    database = sqlite_path(tracking.uri)
    if database is None or not database.exists() or not (reason := unwritable(database)):
        yield tracking
        return
    with writable_copy(database) as copy:
        text = (
            f"{database.parent} cannot be written to ({reason}): MLflow's UI shows a copy; changes made in it are lost"
        )
        console.print(text, soft_wrap=True, markup=False)
        yield replace(tracking, uri=f"{SQLITE}{copy}")


def _serve(tracking: MlflowTracking, port: int, artifacts: Path, study: str | None, browser: bool) -> None:
    from rl_design_space.commands.terminal import console
    from rl_design_space.tracking.address import mlflow_uri
    from rl_design_space.tracking.ui_links import find_pages
    from rl_design_space.tracking.ui_server import serving

    found = find_pages(tracking)
    first = found.first(tracking.uri, study)  # before a server starts
    if tracking.address.is_server:
        console.print(f"MLflow's UI at {first}", soft_wrap=True, markup=False)
        _print(found.links(tracking.uri))
        _open(first, browser)
        return
    with (
        console.status("MLflow's server is starting"),
        serving(mlflow_uri(tracking.address.uri), port, artifacts) as address,
    ):
        first = found.first(address, study)
        console.print(f"MLflow's UI at {first}; Ctrl-C ends it", soft_wrap=True, markup=False)
        _print(found.links(address))
        _open(first, browser)
        while True:
            signal.pause()


def _open(address: str, browser: bool) -> None:
    import webbrowser

    if browser and not webbrowser.open(address):
        tell("no browser was found: open the address by hand")


def _print(links: Mapping[str, str]) -> None:
    """Print one line per link, without wrapping, so that terminals recognise the links."""
    from rl_design_space.commands.terminal import console

    width = max(map(len, links))
    for what, address in links.items():
        console.print(f"{what:<{width}}  {address}", soft_wrap=True, markup=False)
