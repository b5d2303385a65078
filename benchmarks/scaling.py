"""What the cost of this package depends on; textbook C beside it where the job is the same.

All cases take turns within a round. Every call has a seed of its own, so nothing is found in a cache. As in the race,
layouts are drawn within the measured time of ours and outside that of C.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np
import pandas as pd

from benchmarks.client import last_core, pinned
from benchmarks.decisions import decisions_per_move
from benchmarks.decisions import point as msa_point
from benchmarks.job import Job
from benchmarks.peers import Missing, load, ours
from benchmarks.tables import spread
from rl_design_space import DesignPoint, simulate
from rl_design_space.design import AdHoc, Direct, Direction, Distance, Linear, Representation, Task, Torus
from rl_design_space.learning.cores import available_threads
from rl_design_space.learning.lanes import LANES
from rl_design_space.learning.streams import layouts

OURS, TEXTBOOK = ours.TITLE, "C, textbook"
#: What varies within a panel; its first value is the base of the ratios.
WORLD, PERIODS, REPRESENTATION = "side of the world", "periods", "representation"
ACTIONS, ACTIONS_BY_STEP, THREADS = "actions", "actions, by the step", "threads"

SIDES = (10, 20, 30, 50, 100)
PERIOD_COUNTS = (1, 3, 10, 30, 100, 500, 2000)
REPRESENTATIONS: dict[str, Representation] = {
    "ad hoc": AdHoc(),
    "distance": Distance(),
    "direction": Direction(),
    "direct": Direct(),
}
#: MSA sets by the number of actions that they make.
MSA_SETS: dict[int, tuple[int, ...]] = {4: (), 8: (3,), 16: (2, 3, 5)}


@dataclass(frozen=True)
class Case:
    """One thing to measure.

    Attributes:
        panel, line, x: where it belongs in table and plot.
        unit: what is counted, steps or decisions.
        run: takes a seed, learns, and returns seconds and units.
        free: whether it may use all cores.
    """

    panel: str
    line: str
    x: int | str
    unit: str
    run: Callable[[int], tuple[float, float]]
    free: bool = False


def cases(periods: int, counted_periods: int) -> list[Case]:
    """Everything that is measured.

    Args:
        periods: of a call on 10×10; on larger worlds fewer, for about as many steps, but enough for lanes to be full.
        counted_periods: on which decisions are counted.
    """
    everything = []
    for side in SIDES:
        job, count = Job(side=side), max(2 * LANES, round(periods * (SIDES[0] / side) ** 2))
        everything += [Case(WORLD, line, side, "step", run) for line, run in _same_job(job, count)]
    for count in (count for count in PERIOD_COUNTS if count <= 4 * periods):
        everything += [Case(PERIODS, line, count, "step", run) for line, run in _same_job(Job(), count)]
    for name, representation in REPRESENTATIONS.items():
        everything.append(Case(REPRESENTATION, OURS, name, "step", _ours(_represented(representation, periods))))
    for actions, lengths in MSA_SETS.items():
        share = decisions_per_move(lengths, counted_periods)
        msa = _with_msa(lengths, periods)
        everything.append(Case(ACTIONS, OURS, actions, "decision", _ours(msa, share=share)))
        everything.append(Case(ACTIONS_BY_STEP, OURS, actions, "step", _ours(msa)))
    for threads in range(1, min(2, available_threads()) + 1):
        run = _ours(_represented(AdHoc(), 4 * periods), threads)
        everything.append(Case(THREADS, OURS, threads, "step", run, free=True))
    return everything


def measure(measured: Sequence[Case], rounds: int, report: Callable[[str], None] = print) -> pd.DataFrame:
    """Run all cases in turn. One row a case and round: panel, line, x, unit, round, seconds, units, ns."""
    rows = []
    for round_ in range(-1, rounds):
        for position, case in enumerate(measured):
            with pinned(None if case.free else last_core()):
                # No two calls share a seed.
                seconds, units = case.run((round_ + 1) * len(measured) + position)
            # The round before the first one compiles.
            if round_ >= 0:
                rows.append((case.panel, case.line, case.x, case.unit, round_, seconds, units, 1e9 * seconds / units))
        report("scaling: compiled" if round_ < 0 else f"scaling: round {round_ + 1} of {rounds}")
    return pd.DataFrame(rows, columns=["panel", "line", "x", "unit", "round", "seconds", "units", "ns"])


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles of ns and of the ratio to the first value of the panel, round by round."""
    base = calls.groupby(["panel", "line", "round"], sort=False)["ns"].transform("first")
    grouped = calls.assign(ratio=calls["ns"] / base).groupby(["panel", "line", "x", "unit"], sort=False)
    columns = {}
    for name in ("ns", "ratio"):
        columns[name] = grouped[name].median()
        columns[f"{name}_q25"] = grouped[name].quantile(0.25)
        columns[f"{name}_q75"] = grouped[name].quantile(0.75)
    columns["units_per_call"] = grouped["units"].mean()
    return pd.DataFrame(columns).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "what varies": row["panel"],
            "value": row["x"],
            "implementation": row["line"],
            "ns": spread(row, "ns", "ns_q25", "ns_q75"),
            "a": row["unit"],
            "ratio to the first": spread(row, "ratio", "ratio_q25", "ratio_q75"),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _same_job(job: Job, periods: int) -> list[tuple[str, Callable[[int], tuple[float, float]]]]:
    """Ours, and textbook C where there is a compiler, at the same job."""
    lines = [(OURS, _ours(lambda seed: ours.point(job, periods, seed)))]
    try:
        learn = load("textbook_c").prepare(job)
    except Missing:
        return lines

    def run(seed: int) -> tuple[float, float]:
        drawn = layouts(seed, job.cells, job.goals, periods)
        started = perf_counter()
        total = learn(drawn, seed)
        return perf_counter() - started, float(total.sum())

    return [*lines, (TEXTBOOK, run)]


def _ours(
    point: Callable[[int], DesignPoint], threads: int = 1, share: float = 1.0
) -> Callable[[int], tuple[float, float]]:
    """Time a point of any seed; `share` turns moves into units."""

    def run(seed: int) -> tuple[float, float]:
        started = perf_counter()
        curves = simulate(point(seed), threads=threads)
        return perf_counter() - started, share * float(np.sum(curves.total_steps))

    return run


def _represented(representation: Representation, periods: int) -> Callable[[int], DesignPoint]:
    return lambda seed: DesignPoint(
        seed=seed,
        task=Task(periods=periods),
        world=Torus(),
        representation=representation,
        exploration=Linear(),
    )


def _with_msa(lengths: tuple[int, ...], periods: int) -> Callable[[int], DesignPoint]:
    return lambda seed: msa_point(lengths, periods, seed)
