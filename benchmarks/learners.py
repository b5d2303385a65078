"""Each learner beside textbook C (peers/learners.c) of that learner, in turns, on the job of the race.

Times are those of the processor, and of all rounds the least: what else the machine does can only add to them.
"""

from __future__ import annotations

import ctypes
import subprocess
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd

from benchmarks.job import Job
from benchmarks.peers.textbook_c import _COMPILER, _FLAGS, _Job, _pointer
from benchmarks.tables import number
from rl_design_space.design import (
    DesignPoint,
    DoubleQ,
    DynaQ,
    ExpectedSarsa,
    Linear,
    NStep,
    QLambda,
    Sarsa,
    TabularLearner,
    Task,
)
from rl_design_space.learning import simulate
from rl_design_space.learning.streams import layouts

_SOURCE = Path(__file__).with_name("peers") / "learners.c"
_PERIODS = 50


@dataclass(frozen=True)
class Case:
    """A learner, and its number and parameters in C."""

    learner: TabularLearner
    kind: int
    count: int = 0
    decay: float = 0.0


CASES = {
    "Sarsa": Case(Sarsa(), 0),
    "expected Sarsa": Case(ExpectedSarsa(), 1),
    "double Q-learning": Case(DoubleQ(), 2),
    "4-step Sarsa": Case(NStep(n=4), 3, count=4),
    "Q(λ), λ = 0.8": Case(QLambda(trace_decay=0.8), 4, decay=0.8),
    "Dyna-Q, 10 planning steps": Case(DynaQ(planning=10), 5, count=10),
}


def measure(rounds: int, report: Callable[[str], None]) -> pd.DataFrame:
    """Return one row a timed call: learner, who, nanoseconds a step, mean total steps."""
    job, rows = Job(), []
    with TemporaryDirectory() as folder:
        library = _library(Path(folder))
        for name, case in CASES.items():
            point = DesignPoint(exploration=Linear(k=job.epsilon_k), learner=case.learner, task=Task(periods=_PERIODS))
            simulate(point, threads=1)
            for round_ in range(rounds):
                rows.append((name, "C", *_in_c(library, job, case, round_)))
                rows.append((name, "ours", *_ours(point, round_)))
            report(f"{name}: {rounds} rounds")
    return pd.DataFrame(rows, columns=["learner", "who", "ns", "total_steps"])


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Return one row a learner: the least times, their ratio, and by how much the mean total steps differ."""
    least = calls.groupby(["learner", "who"], sort=False)["ns"].min().unstack()
    total = calls.groupby(["learner", "who"], sort=False)["total_steps"].mean().unstack()
    return pd.DataFrame(
        {
            "learner": least.index,
            "c_ns": least["C"].to_numpy(),
            "ours_ns": least["ours"].to_numpy(),
            "ratio": (least["ours"] / least["C"]).to_numpy(),
            "difference": (total["ours"] / total["C"] - 1).to_numpy(),
        }
    )


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the table that people read."""
    return pd.DataFrame(
        {
            "learner": frame["learner"],
            "textbook C, ns a step": frame["c_ns"].map(number),
            "ours": frame["ours_ns"].map(number),
            "ours / C": frame["ratio"].map(number),
            "total steps, ours against C": frame["difference"].map("{:+.1%}".format),
        }
    )


def _library(folder: Path) -> ctypes.CDLL:
    target = folder / "learners.so"
    subprocess.run([_COMPILER, *_FLAGS, "-shared", "-fPIC", "-o", target, _SOURCE], check=True, timeout=60)
    return ctypes.CDLL(str(target))


def _in_c(library: ctypes.CDLL, job: Job, case: Case, seed: int) -> tuple[float, float]:
    fields = {**asdict(job), "cells": job.cells}
    struct = _Job(**{name: fields[name] for name, *_ in _Job._fields_})
    next_cell, epsilon = job.next_cell(), job.epsilon()
    places = np.ascontiguousarray(layouts(seed, job.cells, job.goals, _PERIODS))
    total = np.empty(_PERIODS, dtype=np.int64)
    began = time.process_time()
    library.learn(
        ctypes.byref(struct), case.kind, case.count, ctypes.c_double(case.decay), _pointer(next_cell),
        _pointer(epsilon), _pointer(places), _PERIODS, ctypes.c_uint64(seed + 1), _pointer(total),
    )  # fmt: skip
    return 1e9 * (time.process_time() - began) / total.sum(), float(total.mean())


def _ours(point: DesignPoint, seed: int) -> tuple[float, float]:
    point = replace(point, seed=seed)
    began = time.process_time()
    steps = simulate(point, threads=1).steps
    return 1e9 * (time.process_time() - began) / steps.sum(), float(steps.sum(axis=1).mean())
