"""`python -m benchmarks`: everything, or one part of it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import ModuleType

from benchmarks import (
    browse,
    learners,
    reports,
    roofline,
    scaling,
    scaling_plot,
    search,
    start,
    sweep,
    tracking,
    waits,
    writers,
)
from benchmarks.client import ROOT
from benchmarks.peers import PEERS
from benchmarks.race import Setting, race
from benchmarks.race_table import calls_frame, frame_of, text_of, versions
from benchmarks.results import Results
from benchmarks.search_studies import PERIODS, STUDIES
from benchmarks.tables import console


def main(arguments: list[str] | None = None) -> int:
    """Run the chosen parts.

    Returns:
        Exit status: 1 if a peer does another job or has failed.
    """
    chosen = _parser().parse_args(arguments)
    return max([part(chosen) for name, part in PARTS.items() if chosen.only in (None, name)])


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few rounds: shows that all works, times are rough")
    parser.add_argument("--only", choices=PARTS, help="one of the parts")
    parser.add_argument("--outputs", type=Path, default=ROOT / "outputs" / "benchmarks", help="folder for the results")
    parser.add_argument("--rounds", type=int, help="timed rounds of every part")
    parser.add_argument("--peers", nargs="+", default=PEERS, metavar="NAME", help=f"of {', '.join(PEERS)}")
    parser.add_argument(
        "--python", nargs="+", default=[], metavar="NAME=PATH", help="run a peer with another interpreter"
    )
    return parser


def _race(chosen: argparse.Namespace) -> int:
    setting = Setting(
        peers=chosen.peers,
        rounds=chosen.rounds or (2 if chosen.quick else 15),
        check_periods=12 if chosen.quick else 40,
        pythons=dict(pair.split("=", 1) for pair in chosen.python),
    )
    results = Results(chosen.outputs, "race", "Time a step, beside others")
    entrants = race(setting, console.print)
    frame = frame_of(entrants)
    results.save(frame, text_of(frame), calls_frame(entrants), versions(frame))
    return int(frame["state"].isin(["VOID", "failed"]).any())


def _scaling(chosen: argparse.Namespace) -> int:
    results = Results(chosen.outputs, "scaling", "What the cost depends on")
    measured = scaling.cases(periods=200 if chosen.quick else 500, counted_periods=10 if chosen.quick else 50)
    calls = scaling.measure(measured, chosen.rounds or (2 if chosen.quick else 11), console.print)
    frame = scaling.summary(calls)
    results.save(frame, scaling.text_of(frame), calls)
    scaling_plot.plot(calls, chosen.outputs / "scaling.png")
    return 0


def _tracking(chosen: argparse.Namespace) -> int:
    """What recording costs, how much a store takes, and how long one waits for all of it."""
    _part("tracking", tracking, "What it costs to record a point", chosen, rounds=3)
    rounds, quick = chosen.rounds or (1 if chosen.quick else 3), chosen.quick
    results = Results(chosen.outputs, "writers", "How many points a store takes")
    points = {store: count // 10 if quick else count for store, count in writers.POINTS.items()}
    calls = writers.measure(rounds, console.print, points=points)
    frame = writers.summary(calls)
    results.save(frame, writers.text_of(frame), calls)
    results = Results(chosen.outputs, "waits", "How long one waits for a sweep")
    calls = waits.measure(rounds, console.print, cases=waits.waits(200, 30) if quick else waits.waits())
    frame = waits.summary(calls)
    results.save(frame, waits.text_of(frame), calls)
    return 0


def _reports(chosen: argparse.Namespace) -> int:
    results = Results(chosen.outputs, "reports", "How long one waits for reports and for 10,000 runs")
    calls = reports.measure(
        chosen.rounds or (1 if chosen.quick else 3),
        console.print,
        periods=10 if chosen.quick else 500,
        runs=500 if chosen.quick else 10_000,
    )
    frame = reports.summary(calls)
    results.save(frame, reports.text_of(frame), calls)
    return 0


def _search(chosen: argparse.Namespace) -> int:
    results = Results(chosen.outputs, "search", "Steps to find the best of a thousand points")
    studies = ("schedules",) if chosen.quick else tuple(STUDIES)
    rounds, periods = chosen.rounds or (1 if chosen.quick else 3), 60 if chosen.quick else PERIODS
    calls = search.measure(rounds, console.print, folder=chosen.outputs, periods=periods, studies=studies)
    frame = search.summary(calls)
    results.save(frame, search.text_of(frame), calls)
    return 0


def _part(name: str, module: ModuleType, title: str, chosen: argparse.Namespace, rounds: int = 9) -> int:
    """A part that is nothing but measuring and a table."""
    results = Results(chosen.outputs, name, title)
    calls = module.measure(chosen.rounds or (2 if chosen.quick else rounds), console.print)
    frame = module.summary(calls)
    results.save(frame, module.text_of(frame), calls)
    return 0


PARTS: dict[str, Callable[[argparse.Namespace], int]] = {
    "race": _race,
    "scaling": _scaling,
    "start": partial(_part, "start", start, "From the command to the first result"),
    "roofline": partial(_part, "roofline", roofline, "Where the time of a step goes"),
    "learners": partial(_part, "learners", learners, "Each learner beside textbook C of that learner", rounds=15),
    "tracking": _tracking,
    "sweep": partial(_part, "sweep", sweep, "What a point of a sweep costs beside learning and recording"),
    "browse": partial(_part, "browse", browse, "How long one waits at 10,000 runs", rounds=3),
    "reports": _reports,
    "search": _search,
}

if __name__ == "__main__":
    sys.exit(main())
