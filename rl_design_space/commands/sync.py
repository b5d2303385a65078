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

    from rl_design_space.sweep.settings import store_of
    from rl_design_space.terminal import console, counted
    from rl_design_space.tracking.spool import Spool
    from rl_design_space.tracking.writer import deliver_all

    options = store_of(overrides)
    left = 0
    for spool in Spool.all_under(Path(options.spool)):
        waiting = len(spool.waiting())
        if not waiting:
            continue
        what = counted(waiting, "record")
        console.print(f"{what} for {spool.address.uri} …", markup=False, soft_wrap=True)
        why = deliver_all(spool, options.patience)
        still = len(spool.waiting())
        left += still
        done = f"{waiting - still:,} of {what} delivered"
        console.print(f"{done}; {still:,} still wait: {why}" if still else done, markup=False, soft_wrap=True)
        for path in spool.aside()[-(waiting - still) :]:
            console.print(f"set aside: {path}", markup=False, soft_wrap=True)
    if not left:
        console.print("nothing waits to be delivered")
    else:
        sys.exit(1)
