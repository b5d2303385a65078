"""Open MLflow's UI on the recorded runs, with a view per study."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rl_design_space.tracking import MlflowTracking


def main(arguments: Sequence[str]) -> None:
    """Serve the UI until Ctrl-C or SIGTERM; if the store is a tracking server, print its links instead.

    Raises:
        ConfigError: nothing is recorded, the store cannot be used, or the port is in use.
    """
    parser = argparse.ArgumentParser(
        prog="rl-design-space ui",
        description="Open MLflow's UI on the recorded runs: all design points, all sweeps, and a view per study.",
        epilog="example: rl-design-space ui outputs=outputs/quick --port 5001",
    )
    parser.add_argument("overrides", nargs="*", help="settings, e.g. outputs=DIR or tracking.uri=URI")
    parser.add_argument("--port", type=int, default=5000, help="port of the UI on this machine (default: 5000)")
    given = parser.parse_intermixed_args(arguments)
    with suppress(KeyboardInterrupt):
        show(given.overrides, given.port)


def show(overrides: Sequence[str], port: int) -> None:
    """Serve the UI until it is interrupted; if the store is a tracking server, print its links instead.

    Args:
        overrides: settings, which select the store.
        port: port of the UI.

    Raises:
        ConfigError: nothing is recorded, the store cannot be used, or the port is in use.
        KeyboardInterrupt: raised after the server has stopped.
    """
    from rl_design_space.run.settings import settings_of, store_of

    with _writable(store_of(overrides)) as tracking:
        _serve(tracking, port, Path(settings_of(overrides).outputs) / "artifacts")


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


def _serve(tracking: MlflowTracking, port: int, artifacts: Path) -> None:
    from rl_design_space.commands.terminal import console
    from rl_design_space.tracking.address import mlflow_uri
    from rl_design_space.tracking.ui_links import find_pages
    from rl_design_space.tracking.ui_server import serving

    found = find_pages(tracking)
    if tracking.address.is_server:
        _print(found.links(tracking.uri))
        return
    with (
        console.status("MLflow's server is starting"),
        serving(mlflow_uri(tracking.address.uri), port, artifacts) as address,
    ):
        console.print(f"MLflow's UI at {address}; Ctrl-C ends it", soft_wrap=True)
        _print(found.links(address))
        while True:
            signal.pause()


def _print(links: Mapping[str, str]) -> None:
    """Print one line per link, without wrapping, so that terminals recognise the links."""
    from rl_design_space.commands.terminal import console

    width = max(map(len, links))
    for what, address in links.items():
        console.print(f"{what:<{width}}  {address}", soft_wrap=True, markup=False)
