"""Look after the store: `status` says what is in it, `compact` gives back the room of deleted runs."""

from __future__ import annotations

import argparse
from collections.abc import Sequence


def main(arguments: Sequence[str]) -> None:
    """Show a store's state, or compact it.

    Raises:
        ConfigError: there is no store, or it cannot be compacted from here.
    """
    parser = argparse.ArgumentParser(prog="rl-design-space store", description=__doc__)
    parser.add_argument("action", choices=["status", "compact"])
    parser.add_argument("overrides", nargs="*", help="which store: outputs=… tracking.uri=…")
    options = parser.parse_args(arguments)

    from rl_design_space.commands.terminal import console
    from rl_design_space.run.settings import store_of
    from rl_design_space.tracking import upkeep

    tracking = store_of(options.overrides)
    if options.action == "compact":
        console.print(upkeep.compact(tracking), markup=False, soft_wrap=True)
    console.print(upkeep.status_table(tracking))
