"""Deliver results that wait on this disk to the stores that did not take them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path


def main(arguments: Sequence[str]) -> None:
    """Deliver what is in the spools under `tracking.spool`; exit with 1 if something is left.

    Raises:
        ConfigError: a store is of no use.
    """
    parser = argparse.ArgumentParser(prog="rl-design-space sync", description=__doc__)
    parser.add_argument(
        "overrides", nargs="*", help="where the spools are and how long to try: outputs=… tracking.patience=…"
    )
    overrides = parser.parse_args(arguments).overrides

    from rl_design_space.commands.terminal import console, counted
    from rl_design_space.run.settings import store_of
    from rl_design_space.tracking.spool import Spool
    from rl_design_space.tracking.writer import deliver_all

    options = store_of(overrides)
    left = 0
    for spool in Spool.all_under(Path(options.spool)):
        waiting, set_aside = len(spool.waiting()), set(spool.aside())
        if not waiting:
            continue
        console.print(f"{counted(waiting, 'record')} for {spool.address.uri} …", markup=False, soft_wrap=True)
        why = deliver_all(spool, options.patience)
        still = len(spool.waiting())
        new_aside = sorted(set(spool.aside()) - set_aside)
        console.print(f"{counted(waiting - still - len(new_aside), 'record')} delivered")
        for path in new_aside:
            console.print(f"set aside, because it cannot be: {path}", markup=False, soft_wrap=True)
        if still:
            console.print(f"{counted(still, 'record')} still to be delivered: {why}", markup=False, soft_wrap=True)
        left += still + len(new_aside)
    if left:
        sys.exit(1)
    console.print("nothing waits to be delivered")
