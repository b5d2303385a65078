"""What the agent of a period knows after a trial, and its way through that trial."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.errors import ConfigError
from rl_design_space.learning.initial import initial_value

if TYPE_CHECKING:
    from rl_design_space.learning.replay import Replay
    from rl_design_space.learning.sequential.method import Path

#: Names of periods, by the steps of all their trials, and of trials, by their steps.
ByRank = Literal["worst", "median", "best"]
RANKS = ("worst", "median", "best")
#: Names of trials, by their place.
PLACES = ("first", "last")


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A period after a trial; states are indexed by success counter and cell.

    Attributes:
        trial: number of the trial.
        steps: its steps.
        success: whether it reached the final goal.
        values: (n_goals, cells), the largest Q-value of each state's observation.
        learned: (n_goals, cells) bool, whether one of its Q-values differs from the initial one.
        greedy: (n_goals, cells, actions) bool, the actions with the largest Q-value.
        visits: (n_goals, cells), how often the agent was in each state up to the end of the trial.
        path: the way of the agent in the trial.
    """

    trial: int
    steps: int
    success: bool
    values: FloatArray
    learned: NDArray[np.bool_]
    greedy: NDArray[np.bool_]
    visits: NDArray[np.int64]
    path: Path


def snapshot(inside: Replay, trial: int) -> Snapshot:
    """Return the snapshot after a trial.

    Args:
        inside: a period with its history and paths.
        trial: number of the trial.
    """
    assert inside.history is not None
    assert inside.paths is not None
    q = inside.history[trial]
    greedy = q == q.max(axis=1, keepdims=True)
    learned = (q != initial_value(inside.point)).any(axis=1)
    visits = np.zeros(inside.row.shape, dtype=np.int64)
    for path in inside.paths[: trial + 1]:
        going = path.counters < len(inside.goals)
        np.add.at(visits, (path.counters[going], path.cells[going]), 1)
    return Snapshot(
        trial=trial,
        steps=int(inside.steps[trial]),
        success=bool(inside.success[trial]),
        values=q.max(axis=1)[inside.row],
        learned=learned[inside.row],
        greedy=greedy[inside.row],
        visits=visits,
        path=inside.paths[trial],
    )


def ranked(steps: FloatArray, name: str) -> int:
    """Return the place of the worst, median or best of some numbers of steps; of equal ones the first.

    Args:
        steps: any order.
        name: one of `RANKS`. The median is the lower one of two.
    """
    order = np.argsort(steps, kind="stable")
    if name == "worst":
        return int(np.argmax(steps))
    return int(order[0] if name == "best" else order[(len(order) - 1) // 2])


def chosen_period(period: int | str, total_steps: FloatArray) -> int:
    """Return the number of a period.

    Args:
        period: its number, or one of `RANKS`, by the steps of all its trials.
        total_steps: (periods,)

    Raises:
        ConfigError: there is no such period.
    """
    return _chosen("period", period, total_steps, RANKS)


def chosen_trial(trial: int | str, steps: NDArray[np.int32]) -> int:
    """Return the number of a trial.

    Args:
        trial: its number, one of `RANKS`, by its steps, or one of `PLACES`.
        steps: (trials,)

    Raises:
        ConfigError: there is no such trial.
    """
    if trial in PLACES:
        return 0 if trial == "first" else len(steps) - 1
    return _chosen("trial", trial, steps.astype(np.float64), (*RANKS, *PLACES))


def _chosen(key: str, wanted: int | str, steps: FloatArray, names: tuple[str, ...]) -> int:
    if wanted in RANKS:
        return ranked(steps, str(wanted))
    is_number = isinstance(wanted, (int, np.integer)) and not isinstance(wanted, bool)
    if not is_number or not 0 <= int(wanted) < len(steps):
        expected = f"should be a number from 0 to {len(steps) - 1}, or {', '.join(names[:-1])} or {names[-1]}"
        raise ConfigError.at(key, wanted, expected)
    return int(wanted)


def edges_of(path: Path, counter: int) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Return the steps between cells that a path makes at a success counter, each once, and how often it makes them.

    Args:
        path: of a trial.
        counter: number of goals reached before the step.

    Returns:
        (edges, 2) cells before and after the step, in the order in which they are first made, and (edges,) counts.
    """
    made = path.counters[:-1] == counter
    pairs = np.stack([path.cells[:-1][made], path.cells[1:][made]], axis=1)
    edges, first, counts = np.unique(pairs, axis=0, return_index=True, return_counts=True)
    order = np.argsort(first)
    return edges[order], counts[order]
