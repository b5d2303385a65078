"""Inspect the tracking store (`status`), or free the disk space of deleted runs (`compact`)."""

from __future__ import annotations

import argparse
from collections.abc import Sequence


def main(arguments: Sequence[str]) -> None:
    """Show the state of a store, or compact it.

    Raises:
        ConfigError: there is no store, or it cannot be compacted from this machine.
    """
    parser = argparse.ArgumentParser(prog="rl-design-space store", description=__doc__)
    parser.add_argument("action", choices=["status", "compact"])
    parser.add_argument("overrides", nargs="*", help="settings, e.g. outputs=DIR or tracking.uri=URI")
    options = parser.parse_args(arguments)

    from rl_design_space.commands.terminal import console
    from rl_design_space.run.settings import store_of
    from rl_design_space.tracking import upkeep

    tracking = store_of(options.overrides)
    if options.action == "compact":
        console.print(upkeep.compact(tracking), markup=False, soft_wrap=True)
    console.print(upkeep.status_table(tracking))
