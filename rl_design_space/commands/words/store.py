"""Inspect the tracking store (`status`), or free the disk space of deleted runs (`compact`)."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from rl_design_space.tracking import MlflowTracking


def main(arguments: Sequence[str]) -> None:
    """Show the state of a store, or compact it.

    Raises:
        ConfigError: there is no store, or it cannot be compacted from this machine.
    """
    parser = argparse.ArgumentParser(prog="rl-design-space store", description=__doc__)
    parser.add_argument("action", choices=["status", "compact"])
    parser.add_argument("overrides", nargs="*", help="settings, e.g. outputs=DIR or tracking.uri=URI")
    options = parser.parse_args(arguments)

    from rich.filesize import decimal

    from rl_design_space.commands.terminal import console
    from rl_design_space.run.settings import store_of
    from rl_design_space.tracking import upkeep

    tracking = store_of(options.overrides)
    if options.action == "compact":
        done = upkeep.compact(tracking)
        sizes = f"the database was {decimal(done.before)}, is {decimal(done.after)}"
        console.print(f"{done.removed:,} deleted runs removed; {sizes}", markup=False, soft_wrap=True)
    console.print(_status_table(tracking))


def _status_table(tracking: MlflowTracking) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.filesize import decimal
    from rich.markup import escape
    from rich.table import Table

    from rl_design_space.tracking import upkeep

    status = upkeep.status(tracking)
    others = [f"{count:,} {name}" for name, count in sorted(status.runs.others.items())]
    pending = f"{status.pending_points:,} points, {status.pending:,} records in all"
    rows = {
        "store": tracking.address.uri,
        "points": f"{status.runs.finished:,} complete in experiment {tracking.experiment!r}",
        "incomplete": ", ".join(others) or "none",
        "deleted": f"{status.runs.deleted:,} runs; `rl-design-space store compact` removes them for good",
        "pending": pending if status.pending else "nothing",
        "quarantined": "nothing",
        **{what: decimal(size) for what, size in status.sizes.items()},
    }
    if found := status.quarantined:
        rows["quarantined"] = f"{len(found):,} records, in {found[0].parent}"
    table = Table(box=SIMPLE_HEAD, show_header=False, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for name, text in rows.items():
        table.add_row(name, escape(text))
    return table
