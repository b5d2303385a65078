"""Where the time of a step goes, and what the machine could do: parts of a turn alone, and waiting for memory.

Each part of a turn is repeated on lanes that stand still in the middle of their periods, so that it costs what it
costs in learning but for what the parts cost each other; what the whole takes beyond their sum is waiting between
them, the ends of trials and new periods. Random look-ups that wait for each other show what a miss costs, by how
much memory they go through.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter

import numpy as np
import pandas as pd
from numba import njit
from numpy.typing import NDArray

from benchmarks.client import last_core, pinned
from benchmarks.job import Job
from benchmarks.peers import ours
from benchmarks.tables import number, spread
from rl_design_space import simulate
from rl_design_space.learning import behaviour, kernel, moving, updating
from rl_design_space.learning.lanes import LANES, empty_lanes
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import learning_tables, observation_codes

WHOLE, DECIDE, MOVE, UPDATE, KEEP = "whole step", "decide", "move and look up", "update", "write back"
WAIT = "look-up that waits"
FOOTPRINTS_KIB = (16, 128, 512, 2048, 8192, 32768)

_compiled = njit(error_model="numpy")


@_compiled
def _decide(turns, lanes, next_of, entries, limits, rules, running, wide):
    for _ in range(turns):
        behaviour.draw(lanes.numbers, wide)
        behaviour.choose(lanes.numbers, lanes.values, wide, limits, rules)


@_compiled
def _move(turns, lanes, next_of, entries, limits, rules, running, wide):
    q = lanes.q.ravel()
    for _ in range(turns):
        moving.move_once(lanes.numbers, lanes.reals, lanes.values, q, running, next_of, entries, limits, None, None)


@_compiled
def _update(turns, lanes, next_of, entries, limits, rules, running, wide):
    for _ in range(turns):
        updating.update(lanes.numbers, lanes.reals, lanes.values, wide, np.uint64(0), limits, rules, True, False, None)


@_compiled
def _keep(turns, lanes, next_of, entries, limits, rules, running, wide):
    q = lanes.q.ravel()
    for _ in range(turns):
        updating.keep(lanes.numbers, lanes.reals, lanes.values, q, running, False)


@_compiled
def _follow(chain, look_ups):
    at = 0
    for _ in range(look_ups):
        at = chain[at]
    return at


_PARTS = {DECIDE: _decide, MOVE: _move, UPDATE: _update, KEEP: _keep}


def measure(
    rounds: int,
    report: Callable[[str], None] = print,
    *,
    turns: int = 20_000,
    look_ups: int = 1_000_000,
    footprints_kib: Sequence[int] = FOOTPRINTS_KIB,
) -> pd.DataFrame:
    """Time every part and look-up in turn.

    Args:
        rounds: number of rounds.
        report: takes a line about the progress.
        turns: how often a part is repeated in a round.
        look_ups: look-ups in a round.
        footprints_kib: memory that the look-ups go through, in KiB.

    Returns:
        One row a case and round: case, kib, round, ns (a step or a look-up).
    """
    cases: list[tuple[str, int, Callable[[int], float]]] = [(WHOLE, 0, _whole)]
    cases += [(name, 0, run) for name, run in _parts(turns).items()]
    cases += [(WAIT, kib, partial(_wait, _chain(kib), look_ups)) for kib in footprints_kib]
    rows = []
    with pinned(last_core()):
        for round_ in range(-1, rounds):
            for case, kib, run in cases:
                ns = run(round_ + 1)
                # The round before the first one compiles.
                if round_ >= 0:
                    rows.append((case, kib, round_, ns))
            report("roofline: compiled" if round_ < 0 else f"roofline: round {round_ + 1} of {rounds}")
    return pd.DataFrame(rows, columns=["case", "kib", "round", "ns"])


def summary(calls: pd.DataFrame) -> pd.DataFrame:
    """Medians and quartiles of ns, and of the share of the whole step within a round."""
    whole = calls["round"].map(calls[calls["case"] == WHOLE].set_index("round")["ns"])
    share = (calls["ns"] / whole).where(calls["kib"] == 0)
    grouped = calls.assign(share=share).groupby(["case", "kib"], sort=False)
    return pd.DataFrame(
        {
            "ns": grouped["ns"].median(),
            "ns_q25": grouped["ns"].quantile(0.25),
            "ns_q75": grouped["ns"].quantile(0.75),
            "share": grouped["share"].median(),
        }
    ).reset_index()


def text_of(frame: pd.DataFrame) -> pd.DataFrame:
    """The table that people read."""
    rows = [
        {
            "part": f"{row['case']}, {row['kib']:,} KiB" if row["kib"] else row["case"],
            "ns": spread(row, "ns", "ns_q25", "ns_q75"),
            "share of the step": number(row["share"]),
        }
        for row in frame.to_dict("records")
    ]
    return pd.DataFrame(rows)


def _whole(seed: int) -> float:
    curves = simulate(ours.point(Job(), 500, seed), threads=1)
    return float(1e9 * curves.seconds / curves.total_steps.sum())


def _parts(turns: int) -> dict[str, Callable[[int], float]]:
    """Every part on lanes of its own, all of them running, in the middle of their periods."""
    point = ours.point(Job(), 2 * LANES, seed=0)
    tables, task = learning_tables(point), point.task
    layout = layouts_of(point)
    generator = behaviour_states(point.seed, task.periods)
    codes = observation_codes(point, layout[: LANES + 1, 1:])
    steps = np.empty((task.periods, task.trials), dtype=np.int32)
    success = np.empty((task.periods, task.trials), dtype=np.bool_)
    rows = np.empty((task.periods, 2), dtype=np.int32)
    next_of = np.ascontiguousarray(tables.next_cell.T).ravel()
    runs: dict[str, Callable[[int], float]] = {}
    for name, part in _PARTS.items():
        lanes = empty_lanes(LANES, codes[0].size, tables.limits)
        # Ends as soon as two periods have, so that the others stand in their last trials.
        kernel.learn(
            tables.next_cell, tables.limits, tables.threshold, tables.rules, codes, 0, layout, generator, lanes,
            False, steps, success, rows, None, None, None, None, None,
        )  # fmt: skip
        running = int(lanes.running[0])
        arguments = (lanes, next_of, lanes.entries.ravel(), tables.limits, tables.rules, running, LANES)
        runs[name] = partial(_timed, part, turns, arguments, running)
    return runs


def _timed(part: Callable[..., None], turns: int, arguments: tuple[object, ...], running: int, _: int) -> float:
    started = perf_counter()
    part(turns, *arguments)
    return 1e9 * (perf_counter() - started) / (turns * running)


def _chain(kib: int) -> NDArray[np.int64]:
    """A cycle through all cache lines of so much memory, in random order: each holds the place of the next."""
    lines = kib * 1024 // 64
    order = np.random.default_rng(0).permutation(lines)
    chain = np.zeros(8 * lines, dtype=np.int64)
    chain[8 * order] = 8 * np.roll(order, -1)
    return chain


def _wait(chain: NDArray[np.int64], look_ups: int, _: int) -> float:
    started = perf_counter()
    _follow(chain, look_ups)
    return 1e9 * (perf_counter() - started) / look_ups
