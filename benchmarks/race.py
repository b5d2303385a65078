"""Who needs how long for the same job: all peers side by side.

Every peer lives in its own process on the same core. First each learns some periods, which takes compilation out of
the way and shows whether all do the same job; a peer that does another one is void and does not race. Then come
rounds, A B C … A B C …, so that whatever else the machine does hits all alike; ratios are taken within a round.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.agreement import Agreement, compare
from benchmarks.client import Timed, Worker, WorkerError
from benchmarks.job import Job
from benchmarks.peers import OURS, PEERS, Missing
from rl_design_space.learning.streams import layouts


@dataclass(frozen=True, kw_only=True)
class Setting:
    """How a race is run.

    Attributes:
        peers: names, see `benchmarks.peers.load`; ours takes part anyway.
        rounds: timed calls of every peer.
        check_periods: learned at least by every peer before the first round.
        periods: most periods of a call; a peer that takes fewer at a time says so itself.
        pythons: interpreters of peers that do not run in this one.
        compiles: whether Numba compiles anew, so that compiling is measured, even if there is code from before.
    """

    job: Job = field(default_factory=Job)
    peers: Sequence[str] = PEERS
    rounds: int = 15
    check_periods: int = 40
    periods: int = 500
    pythons: Mapping[str, str] = field(default_factory=dict)
    compiles: bool = True


class Call(NamedTuple):
    """One timed call of a round."""

    round: int
    seconds: float
    steps: int

    @property
    def ns(self) -> float:
        """Nanoseconds a step."""
        return 1e9 * self.seconds / self.steps


@dataclass
class Entrant:
    """A peer and what came of it.

    Attributes:
        state: `ok`, `missing` or `failed`; a peer that runs may still disagree.
        note: why it is missing or has failed.
        totals: total steps a period, by seed.
    """

    name: str
    title: str
    version: str = ""
    state: str = "ok"
    note: str = ""
    start_seconds: float = math.nan
    compile_seconds: float = math.nan
    peak_mib: float = math.nan
    calls: list[Call] = field(default_factory=list)
    totals: dict[int, NDArray[np.int64]] = field(default_factory=dict)
    agreement: Agreement | None = None

    @property
    def void(self) -> bool:
        """Whether it does another job."""
        return self.agreement is not None and not self.agreement.agrees

    def ratios(self, ours: Entrant) -> list[float]:
        """Time a step over ours, round by round."""
        base = {call.round: call.ns for call in ours.calls}
        return [call.ns / base[call.round] for call in self.calls if call.round in base]


class _Runner:
    """Drives the worker of one entrant."""

    def __init__(self, entrant: Entrant, worker: Worker, setting: Setting) -> None:
        self.entrant, self.worker, self.setting = entrant, worker, setting
        self.periods = min(worker.periods, setting.periods)

    def learn(self, seed: int) -> Timed:
        job = self.setting.job
        timed = self.worker.learn(layouts(seed, job.cells, job.goals, self.periods), seed)
        self.entrant.totals[seed] = timed.total
        self.entrant.peak_mib = timed.peak_mib
        return timed

    def checks(self) -> int:
        """Calls before the first round; two at least, as the first one compiles."""
        return max(2, math.ceil(self.setting.check_periods / self.periods))

    def warm_up(self, calls: int) -> None:
        prepared = self.worker.prepare(self.setting.job)
        first, *later = [self.learn(seed) for seed in range(calls)]
        compiling = first.seconds - median(timed.seconds for timed in later)
        self.entrant.compile_seconds = prepared.seconds + max(0.0, compiling)

    def timed(self, round_: int, seed: int) -> None:
        timed = self.learn(seed)
        self.entrant.calls.append(Call(round_, timed.seconds, int(timed.total.sum())))


def race(setting: Setting, report: Callable[[str], None] = print) -> list[Entrant]:
    """Run the race.

    Args:
        setting: who and how.
        report: told what goes on.

    Returns:
        Every peer of the setting, ours first, with all its numbers.

    Raises:
        WorkerError: ours failed, so there is nothing to compare with.
    """
    names = [OURS, *(name for name in setting.peers if name != OURS)]
    with ExitStack() as stack:
        cache = Path(stack.enter_context(TemporaryDirectory())) if setting.compiles else None
        entrants, runners = [], []
        for name in names:
            entrant, worker = _start(name, cache, setting)
            entrants.append(entrant)
            if worker is not None:
                stack.enter_context(worker)
                runners.append(_Runner(entrant, worker, setting))
            report(f"{name}: {entrant.version or f'skipped, {entrant.note}'}")

        # Ours learns every seed that anybody is checked on.
        most = max(runner.checks() for runner in runners)
        for runner in runners:
            calls = most if runner.entrant.name == OURS else runner.checks()
            _guarded(runner, partial(runner.warm_up, calls), report)
        _check(entrants, report)

        for round_ in range(setting.rounds):
            for runner in runners:
                if runner.entrant.state == "ok" and not runner.entrant.void:
                    _guarded(runner, partial(runner.timed, round_, most + round_), report)
            report(f"round {round_ + 1} of {setting.rounds}")
        _check(entrants, report)
    return entrants


def _start(name: str, cache: Path | None, setting: Setting) -> tuple[Entrant, Worker | None]:
    try:
        worker = Worker(name, cache, **({"python": setting.pythons[name]} if name in setting.pythons else {}))
    except Missing as missing:
        return Entrant(name, name, state="missing", note=str(missing)), None
    except WorkerError as error:
        return Entrant(name, name, state="failed", note=str(error)), None
    return Entrant(name, worker.title, worker.version, start_seconds=worker.start_seconds), worker


def _guarded(runner: _Runner, action: Callable[[], None], report: Callable[[str], None]) -> None:
    """A peer that fails leaves the race; without ours there is none."""
    try:
        action()
    except WorkerError as error:
        if runner.entrant.name == OURS:
            raise
        runner.entrant.state, runner.entrant.note = "failed", str(error)
        report(f"{runner.entrant.name}: failed, {error}")


def _check(entrants: Sequence[Entrant], report: Callable[[str], None]) -> None:
    running = [entrant for entrant in entrants if entrant.state == "ok"]
    verdicts = compare({entrant.name: entrant.totals for entrant in running})
    for entrant in running:
        verdict = entrant.agreement = verdicts[entrant.name]
        if entrant.void:
            report(f"{entrant.name}: VOID, {verdict.difference:+.1%} total steps, {verdict.t:+.1f} standard errors")
    if not any(entrant.void for entrant in running):
        report(f"all {len(running)} agree on the mean total steps")
