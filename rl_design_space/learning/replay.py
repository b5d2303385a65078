"""Looking inside a period: it is learned again, bit for bit, and its Q-values, visits and paths are kept."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.design import DesignPoint, cell_count, stages_of
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked import action_table, behaviour_of, observation_codes
from rl_design_space.learning.earning import earnings, width_of
from rl_design_space.learning.kernel import learn
from rl_design_space.learning.lanes import Lanes, empty_lanes, row_width
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.memory import available_memory
from rl_design_space.learning.optimum import optimal_steps
from rl_design_space.learning.recording import record
from rl_design_space.learning.sequential.method import Notes, Path
from rl_design_space.learning.streams import behaviour_states
from rl_design_space.learning.tables import Tables, learning_tables

#: What can be kept of a period.
Part = Literal["q", "history", "visits", "paths"]
PARTS: tuple[Part, ...] = get_args(Part)
#: Bytes of a step of a path, and bytes of a Q-value.
_STEP, _VALUE = 13, 8


@dataclass(frozen=True, eq=False)
class Replay:
    """A period that was learned again.

    Attributes:
        point: the design point.
        period: number of the period.
        layout: (1 + n_goals,) int32, cells of the start and of the goals.
        optimum: fewest steps possible; in a stochastic world, the fewest that can be expected.
        steps: (trials,) int32, steps of every trial.
        success: (trials,) bool, whether the final goal was reached.
        codes: (n_goals, cells) int64, observation code of every state, by success counter and cell.
        row: (n_goals, cells) int32, row of the Q-matrix of every state; states with the same observation share it.
        made: (actions, n_goals, cells) int8, the step that each action makes in every state: a number of `MOVES`, or
            `WAIT`.
        q: (rows, actions), Q-matrix after the last trial; None if it was not kept, as the following.
        history: (trials, rows, actions), Q-matrix after each trial.
        visits: (n_goals, cells) int64, how often the agent was in each state in all trials, starts included.
        paths: the path of each trial.
    """

    point: DesignPoint
    period: int
    layout: NDArray[np.int32]
    optimum: float
    steps: NDArray[np.int32]
    success: NDArray[np.bool_]
    codes: NDArray[np.int64]
    row: NDArray[np.int32]
    made: NDArray[np.int8]
    q: FloatArray | None = None
    history: FloatArray | None = None
    visits: NDArray[np.int64] | None = None
    paths: tuple[Path, ...] | None = None

    @property
    def start(self) -> int:
        """Cell of the start."""
        return int(self.layout[0])

    @property
    def goals(self) -> tuple[int, ...]:
        """Cells of the goals, in the order in which they are due."""
        return tuple(self.layout[1:].tolist())

    def __repr__(self) -> str:
        kept = ", ".join(part for part in PARTS if getattr(self, part) is not None)
        return (
            f"Replay of period {self.period}: {len(self.steps)} trials, {self.steps.sum():,} steps, "
            f"optimum {self.optimum:.15g}, {int(self.row.max()) + 1} observations; kept: {kept or 'nothing'}"
        )


class Replayer:
    """Learns single periods of a design point again.

    Args:
        point: the design point.

    Raises:
        ConfigError: an option returns a table that violates its contract, or periods have several stages.
    """

    def __init__(self, point: DesignPoint) -> None:
        check_one_stage(point)
        self.point = point
        self._tables = learning_tables(point)
        self._layouts = layouts_of(point)
        self._generator = behaviour_states(point.seed, point.task.periods)

    @property
    def tables(self) -> Tables:
        """The tables that all periods share."""
        return self._tables

    @property
    def layouts(self) -> NDArray[np.int32]:
        """(periods, 1 + n_goals), start and goals of each period."""
        return self._layouts

    def __call__(self, period: int, keep: Iterable[Part] = PARTS) -> Replay:
        """Learn a period again.

        Args:
            period: its number.
            keep: what is kept of it.

        Raises:
            ConfigError: there is no such period, or no such part, or what is to be kept needs more memory than there
                is.
            RuntimeError: the steps are not those of the kernel.
        """
        check_periods(self.point, [period])
        parts = checked_parts(keep)
        tables, task = self._tables, self.point.task
        layout, generator = self._layouts[period : period + 1], self._generator[period : period + 1]
        codes = np.array(observation_codes(self.point, layout[:, 1:]))  # a copy: it may be read-only, another type
        observations = task.goals * cell_count(self.point.world)
        table = action_table(self.point, layout[:, 1:], codes)
        paid = earnings(self.point, tables, layout[:, 1:])
        lanes = empty_lanes(
            1, observations, tables.limits, tabulated=table is not None, drawn=tables.chance is not None,
            earnings=width_of(paid),
        )  # fmt: skip
        steps, success = np.empty((1, task.trials), dtype=np.int32), np.empty((1, task.trials), dtype=np.bool_)
        rows = np.empty((1, 2), dtype=np.int32)
        common = (tables.next_cell, tables.limits, tables.threshold, tables.rules, codes)
        running, what = (0, layout, generator, lanes, True), (table, None, tables.chance, paid)
        learn(*common, *running, steps, success, rows, *what, tables.method)

        # Its number of rows and of steps is known now.
        row = _rows(codes[0])
        places = int(steps.sum()) + task.trials if {"paths", "visits"} & parts else 0
        history_trials = task.trials if "history" in parts else 0
        q_shape = (int(row.max()) + 1, len(tables.limits))
        _check_memory(places * _STEP + (history_trials + 1) * q_shape[0] * q_shape[1] * _VALUE)
        history = np.empty((history_trials, *q_shape))
        numbers, explored = np.empty((3, places), dtype=np.int32), np.zeros(places, dtype=np.bool_)
        trail = Path(numbers[0], numbers[1], numbers[2], explored)
        again, succeeded = np.empty_like(steps), np.empty_like(success)
        if tables.method is None:
            record(
                *common, layout, generator, lanes, history, trail, again[0], succeeded[0], table, tables.chance, paid
            )
        else:
            noted = tables.method._replace(notes=Notes(trail, history))
            learn(*common, *running, again, succeeded, rows, *what, noted)
        if not (np.array_equal(again, steps) and np.array_equal(succeeded, success)):
            raise RuntimeError(f"period {period}: learned again, it took other steps; this is a bug")
        states = (trail.counters * codes.shape[2] + trail.cells)[trail.counters < task.goals]
        visits = np.bincount(states, minlength=observations).reshape(codes.shape[1:])
        return Replay(
            point=self.point,
            period=period,
            layout=layout[0],
            optimum=optimal_steps(tables, layout)[0].item(),
            steps=steps[0],
            success=success[0],
            codes=codes[0],
            row=row,
            made=behaviour_of(self.point, layout[:, 1:], codes).steps[:, 0],
            q=_q_matrix(lanes, q_shape) if "q" in parts else None,
            history=history if "history" in parts else None,
            visits=visits if "visits" in parts else None,
            paths=tuple(_paths(trail, steps[0])) if "paths" in parts else None,
        )


def _paths(trail: Path, steps: NDArray[np.int32]) -> Iterator[Path]:
    """Yield the path of each trial."""
    first = 0
    for count in steps.tolist():
        end = first + count
        yield Path(
            trail.cells[first : end + 1],
            trail.counters[first : end + 1],
            trail.actions[first:end],
            trail.explored[first:end],
        )
        first = end + 1


def check_one_stage(point: DesignPoint) -> None:
    """Refuse a point whose periods have several stages.

    Raises:
        ConfigError: they have.
    """
    if stages_of(point):
        raise ConfigError("curriculum: only periods of one stage can be learned again to look inside")


def check_periods(point: DesignPoint, periods: Iterable[int]) -> None:
    """Refuse numbers of periods that a point does not have.

    Raises:
        ConfigError: there is no such period.
    """
    last = point.task.periods - 1
    for period in periods:
        if isinstance(period, bool) or not isinstance(period, (int, np.integer)) or not 0 <= period <= last:
            raise ConfigError.at("period", period, f"should be a whole number from 0 to {last}")


def checked_parts(keep: Iterable[Part]) -> set[Part]:
    """Return the names of parts.

    Raises:
        ConfigError: there is no such part.
    """
    wanted = list(keep)
    for name in wanted:
        if name not in PARTS:
            raise ConfigError.unknown("part that can be kept", str(name), PARTS)
    return set(wanted)


def replays(point: DesignPoint, keep: Iterable[Part], periods: Sequence[int] | None) -> dict[int, Replay]:
    """Learn periods again; see `simulate`."""
    replayer = Replayer(point)
    chosen = range(point.task.periods) if periods is None else periods
    check_periods(point, chosen)
    return {int(period): replayer(int(period), keep) for period in chosen}


def _rows(codes: NDArray[np.int64]) -> NDArray[np.int32]:
    """Return the rows of the Q-matrix that the kernel gives to codes: in the order in which these first occur."""
    _, first, inverse = np.unique(codes, return_index=True, return_inverse=True)
    numbers: NDArray[np.int32] = np.argsort(np.argsort(first)).astype(np.int32)[inverse].reshape(codes.shape)
    return numbers


def _q_matrix(lanes: Lanes, shape: tuple[int, int]) -> FloatArray:
    """Return a copy of the Q-matrix of the only lane, (rows, actions)."""
    rows, actions = shape
    return lanes.q.reshape(-1, row_width(actions))[:rows, :actions].copy()


def _check_memory(needed: float) -> None:
    """Refuse to keep what cannot fit into memory.

    Raises:
        ConfigError: more memory is needed than there is.
    """
    if needed > (available := available_memory()):
        raise ConfigError(
            f"keep: this needs {needed / 1e9:,.1f} GB of memory, and this machine has {available / 1e9:,.1f} GB; keep "
            "less: history is the largest part"
        )
