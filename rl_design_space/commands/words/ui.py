"""MLflow's UI on what has been recorded, with a view of each study."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path


def main(arguments: Sequence[str]) -> None:
    """Serve the UI until Ctrl-C or SIGTERM, or name the pages of a server that is there.

    Raises:
        ConfigError: nothing was recorded, the store cannot be used or the port is taken.
    """
    parser = argparse.ArgumentParser(
        prog="rl-design-space ui",
        description="MLflow's UI on what has been recorded: all design points, sweeps, and a view of each study.",
        epilog="example: rl-design-space ui outputs=outputs/quick --port 5001",
    )
    parser.add_argument("overrides", nargs="*", help="overrides, as in rl-design-space: outputs=…, tracking.uri=…")
    parser.add_argument("--port", type=int, default=5000, help="where to listen on this machine; 5000 if not given")
    given = parser.parse_intermixed_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with suppress(KeyboardInterrupt):
        show(given.overrides, given.port)


def show(overrides: Sequence[str], port: int) -> None:
    """Serve the UI until it is interrupted, or name the pages of a server that is there.

    Args:
        overrides: of the settings.
        port: to listen at.

    Raises:
        ConfigError: as `main`.
        KeyboardInterrupt: after the server has ended.
    """
    from rl_design_space.commands.terminal import console
    from rl_design_space.run.settings import settings_of, store_of
    from rl_design_space.tracking.ui_links import find_pages
    from rl_design_space.tracking.ui_server import serving

    tracking = store_of(overrides)
    found = find_pages(tracking)
    if tracking.address.is_server:
        _print(found.links(tracking.uri))
        return
    with (
        console.status("MLflow's server is starting"),
        serving(tracking.address.uri, port, Path(settings_of(overrides).outputs) / "artifacts") as address,
    ):
        console.print(f"MLflow's UI at {address}; Ctrl-C ends it", soft_wrap=True)
        _print(found.links(address))
        while True:
            signal.pause()


def _print(links: Mapping[str, str]) -> None:
    """A line a page, never broken, so that a terminal makes a link of it."""
    from rl_design_space.commands.terminal import console

    width = max(map(len, links))
    for what, address in links.items():
        console.print(f"{what:<{width}}  {address}", soft_wrap=True, markup=False)
