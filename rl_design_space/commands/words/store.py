"""Inspect the tracking store, check its files, have runs learned anew, or free the disk space of deleted runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rl_design_space.commands.arguments import Parser

if TYPE_CHECKING:
    from rich.table import Table

    from rl_design_space.tracking import MlflowTracking
    from rl_design_space.tracking.run_files import DamagedFileError

_USAGE = """rl-design-space store status [--check] [KEY=VALUE ...]
       rl-design-space store forget RUN_ID ... [KEY=VALUE ...]
       rl-design-space store forget --damaged [KEY=VALUE ...]
       rl-design-space store compact [KEY=VALUE ...]"""
_EPILOG = """actions:
  status     what the store holds; with --check, also read every file and name the damaged ones (exit status 1)
  forget     delete runs in MLflow, by id or because they are damaged (--damaged); the next sweep learns their points
             anew; until compact removes them, `mlflow runs restore --run-id RUN_ID` undoes it
  compact    remove deleted runs for good, and release their space
"""


def main(arguments: Sequence[str]) -> None:
    """Show the state of a store, check it, forget runs, or compact it; exit with status 1 if files are damaged.

    Raises:
        ConfigError: there is no store or no such run, or the store cannot be compacted from this machine.
    """
    parser = Parser(
        prog="rl-design-space store",
        usage=_USAGE,
        description=__doc__,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("action", choices=["status", "forget", "compact"])
    parser.add_argument("--check", action="store_true", help="of status: read the files of every run")
    parser.add_argument("--damaged", action="store_true", help="of forget: the runs that status --check names")
    parser.add_argument("words", nargs="*", metavar="RUN_ID | KEY=VALUE", help="runs; settings, e.g. outputs=DIR")
    options = parser.parse_intermixed_args(arguments)
    run_ids = [word for word in options.words if "=" not in word] if options.action == "forget" else []
    if options.check and options.action != "status":
        parser.error("--check belongs to status")
    if options.damaged and options.action != "forget":
        parser.error("--damaged belongs to forget")
    if options.action == "forget" and not run_ids and not options.damaged:
        parser.error("forget needs the ids of runs, or --damaged")

    from rl_design_space.run.settings import store_of

    tracking = store_of([word for word in options.words if word not in run_ids])
    if options.action == "forget":
        _forget(tracking, run_ids, options.damaged)
        return
    if options.action == "compact":
        _compact(tracking)
    _show_status(tracking)
    if options.check and _show_damaged(_damaged(tracking)):
        sys.exit(1)


def _compact(tracking: MlflowTracking) -> None:
    from rich.filesize import decimal

    from rl_design_space.commands.terminal import console
    from rl_design_space.tracking import upkeep

    done = upkeep.compact(tracking)
    sizes = f"the database was {decimal(done.before)}, is {decimal(done.after)}"
    console.print(f"{done.removed:,} deleted runs removed; {sizes}", markup=False, soft_wrap=True)


def _forget(tracking: MlflowTracking, run_ids: Sequence[str], damaged: bool) -> None:
    from rl_design_space.commands.terminal import console, counted
    from rl_design_space.tracking import upkeep

    chosen = [*run_ids, *(found.run_id for found in _damaged(tracking))] if damaged else run_ids
    for run in upkeep.forget(tracking, chosen):
        console.print(f"forgotten: {run.name} (run {run.run_id})", markup=False, soft_wrap=True)
    again = "; the commands that ran their points learn them anew" if chosen else ""
    console.print(f"{counted(len(set(chosen)), 'run')} forgotten{again}", markup=False, soft_wrap=True)


def _damaged(tracking: MlflowTracking) -> list[DamagedFileError]:
    from rich.progress import track

    from rl_design_space.commands.terminal import console
    from rl_design_space.tracking import upkeep

    runs = upkeep.complete_runs(tracking)
    checks = upkeep.check(tracking, runs)
    silent = not console.is_terminal
    checked = track(checks, "checking files", len(runs), console=console, transient=True, disable=silent)
    return [found for found in checked if found]


def _show_damaged(damaged: Sequence[DamagedFileError]) -> bool:
    from rl_design_space.commands.terminal import console, counted

    for found in damaged:
        text = f"damaged: run {found.run_id}: {found.file}: {found.reason}"
        console.print(text, markup=False, soft_wrap=True)
    if damaged:
        command = "to learn their points anew: rl-design-space store forget --damaged, then the commands that ran them"
        console.print(f"{counted(len(damaged), 'damaged run')}; {command}", markup=False, soft_wrap=True)
    else:
        console.print("the files of all complete runs are as they were recorded", markup=False)
    return bool(damaged)


def _show_status(tracking: MlflowTracking) -> None:
    from rl_design_space.commands.terminal import console

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
