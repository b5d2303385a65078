"""The task as a Gymnasium environment for other learners, with the dynamics that the kernel learns on.

    import gymnasium
    import rl_design_space as rds
    import rl_design_space.environment  # registers the environment

    env = gymnasium.make("rl_design_space/OrderedGoals-v0", point=rds.DesignPoint(representation=rds.Direction()))

Requires Gymnasium: `pip install 'rl-design-space[gym]'`.
"""

from __future__ import annotations

from typing import Any, Literal, TypeVar

import numpy as np

from rl_design_space.errors import ConfigError

try:
    import gymnasium
except ImportError as missing:
    raise ConfigError("rl_design_space.environment: needs Gymnasium; pip install 'rl-design-space[gym]'") from missing

from gymnasium.error import InvalidAction, ResetNeeded
from gymnasium.spaces import Discrete

from rl_design_space.design import WAIT, DesignPoint, SizedRepresentation, cell_count, stages_of
from rl_design_space.learning.earning import is_paid, rewards_by_transition
from rl_design_space.learning.layouts import layouts_of
from rl_design_space.learning.optimum import needed, optimal_steps
from rl_design_space.learning.tables import behaviour_of, learning_tables, observation_codes

__all__ = ["ID", "OrderedGoals"]

ID = "rl_design_space/OrderedGoals-v0"

_OBSERVATIONS = ("row", "code")
_LARGEST_CODE = 2**63 - 1
_Entry = TypeVar("_Entry", int, bool)


class OrderedGoals(gymnasium.Env[Any, Any]):
    """Goals on a grid, to be reached in order: an episode is a trial of a period of a design point.

    A *step* of the grid is one cell's worth of movement; a call of `step` carries out an action of one or more of them.

    **Layout.** Start and goals are those that the kernel draws for one of the `task.periods` periods of the point:

    - `period="seed"`, the default: `reset(seed=s)` begins period s % task.periods, so the environments of a vector,
      whose seeds are consecutive, have different layouts. If the first reset has no seed, it draws a period. Further
      resets without a seed keep the layout, as the trials of a period do.
    - `period=7`: always period 7, whatever the seed.
    - `period=None`: every reset draws a period; `reset(seed=s)` makes the draws repeatable.

    `reset(options={"period": p})` begins period p in each case; later resets keep it, except with `period=None`.

    **Observation.** The observation of the representation, as one number:

    - `row`: 0 … n_goals · cells - 1, the row of the Q-matrix that the kernel uses, so a table of
      `observation_space.n` rows is enough for every representation. Each layout has its own numbering of rows.
    - `code`: the observation code of the representation, which has the same meaning in every layout, for learners that
      transfer what they have learned to another layout. There may be very many codes. `info` always contains it.

    Different states may have equal observations (representations differ in this), so the environment is in general
    not Markov. The final goal is terminal and has no observation; the one returned there must not be bootstrapped from.

    **Action.** The actions of `msa`, in its order. Of multi-step actions, action a repeats the primitive action a % 4
    (right, left, above, below) `msa.action_lengths()[a // 4]` times; other sets say what their actions do at each
    observation. An action of several steps ends early at the final goal, at the step cap, at a sub-goal with
    `msa.sub_goal: stop`, and where its own rule stops it.

    **Chance.** In a stochastic world, where a step leads is drawn from the generator of the environment, which
    `reset(seed=s)` seeds.

    **Reward.** The reward of the step, shaped if the reward has a potential; for a multi-step action Σ γ^j r_j over
    its steps, or the return of `msa.reward: printed`, with γ = `learner.gamma`. A learner then bootstraps with
    γ^executed.

    **End.** Terminated at the final goal; truncated after `task.max_steps` steps.

    **Info.** `period`; `code`; `moves`, the steps of the episode; `reached`, the success counter; `optimum`, the
    fewest steps possible, or those that can be expected in a stochastic world. After an action also `executed`, its
    number of steps; `rewards`, one per step; `made`, the step itself, right 0, left 1, above 2, below 3, or 4 for
    none; and `path`, the observation before each step. So step j leads from `path[j]` to `path[j + 1]`, and the last
    step to the observation returned: a learner needs this to update shorter actions from a longer one.

    The other values of a point concern the learner: exploration, α, initial Q-values, explore, ties, update, MSA
    propagation, and the number of trials. `learner.out_of_order` and, for multi-step actions, γ are the exceptions.

    Args:
        point: world, representation, actions, rewards, goals, step cap and seed; the paper's defaults if None.
        period: the period whose layout is used: 0 … task.periods - 1, "seed" or None, see Layout.
        observation: "row" or "code".
        render_mode: "ansi" if `render` should return the grid as text.

    Raises:
        ConfigError: an argument is not allowed, or an option of the point returns a table that breaks its contract.
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi"], "render_fps": 4}  # noqa: RUF012 (declared like this by Env)

    def __init__(
        self,
        point: DesignPoint | None = None,
        period: int | Literal["seed"] | None = "seed",
        observation: Literal["row", "code"] = "row",
        render_mode: str | None = None,
    ) -> None:
        point = DesignPoint() if point is None else point
        if not isinstance(point, DesignPoint):
            raise ConfigError.at("point", point, "should be a DesignPoint")
        if stages_of(point):
            raise ConfigError("curriculum: an environment is one stage; use the point of a stage, see stages_of(point)")
        if observation not in _OBSERVATIONS:
            raise ConfigError.unknown("observation", observation, _OBSERVATIONS)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ConfigError.unknown("render mode", str(render_mode), self.metadata["render_modes"])
        self.point, self.render_mode = point, render_mode
        task, cells = point.task, cell_count(point.world)
        self._tables = learning_tables(point)
        self._next_cell: list[list[int]] = [*self._tables.next_cell.tolist(), list(range(cells))]
        self._layouts = layouts_of(point)
        self._by_row = observation == "row"
        self._seeded, self._draws = period == "seed", period is None
        self.action_space = Discrete(len(self._tables.limits))
        self.observation_space = Discrete(task.goals * cells if self._by_row else _code_count(point))
        self._enter(0 if self._seeded or self._draws else self._checked(period, ', "seed" or None'))
        self._begin()
        self._over = self._is_new = True

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[int, dict[str, Any]]:
        """Return the agent to the start.

        Args:
            seed: chooses the layout, see the class, and what happens by chance in a stochastic world.
            options: `{"period": p}` chooses the layout of period p, whatever the seed.

        Raises:
            ConfigError: the option or the period does not exist.
        """
        super().reset(seed=seed)
        options = options or {}
        for name in options:
            if name != "period":
                raise ConfigError.unknown("option of reset", name, ["period"])
        if "period" in options:
            self._enter(self._checked(options["period"]))
        elif self._seeded and seed is not None:
            self._enter(int(seed) % len(self._layouts))
        elif self._draws or (self._seeded and self._is_new):
            self._enter(int(self.np_random.integers(len(self._layouts))))
        self._is_new = False
        self._begin()
        self._over = False
        return self._observe(), self._info()

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        """Carry out an action.

        Raises:
            gymnasium.error.ResetNeeded: the episode has ended or has not begun.
            gymnasium.error.InvalidAction: the action does not exist.
        """
        if self._over:
            raise ResetNeeded("the episode has ended or has not begun; call reset() first")
        if not self.action_space.contains(action):
            last = len(self._tables.limits) - 1
            raise InvalidAction(f"action {action!r}: should be a whole number from 0 to {last}")
        limit = self._tables.limits[int(action)]
        path: list[int] = []
        made: list[int] = []
        rewards: list[float] = []
        mark = self._at(self._marks)
        ended = False
        while not ended:
            path.append(self._observe())
            made.append(self._at(self._steps_of[int(action)]))
            reached = self._reached
            rewards.append(self._step(made[-1]))
            stops = self._at(self._stops_of[int(action)]) or self._at(self._marks) != mark
            stops = stops or (self._tables.rules.stop_at_sub_goal and self._reached > reached)
            ended = self._ended() or stops or len(rewards) == limit
        self._over = self._ended()
        terminated = self._reached == self.point.task.goals
        info = {**self._info(), "executed": len(rewards), "rewards": tuple(rewards)}
        info |= {"made": tuple(made), "path": tuple(path)}
        return self._observe(), self._return(rewards, limit), terminated, self._over and not terminated, info

    def render(self) -> str | None:
        """Return the grid: agent A, start S, goals ahead by number, goals reached as *; None without a render mode."""
        if self.render_mode is None:
            return None
        width, height = self.point.world.shape
        start, *goals = self.layout
        cells = ["."] * (width * height)
        cells[start] = "S"
        for number, goal in enumerate(goals, start=1):
            cells[goal] = "*" if number <= self._reached else str(number)
        cells[self._cell] = "A"
        digits = len(str(len(goals)))
        rows = [cells[first : first + width] for first in range(0, len(cells), width)]
        grid = [" ".join(cell.rjust(digits) for cell in row) for row in rows]
        due = f"goal {self._reached + 1} of {len(goals)} is due" if self._reached < len(goals) else "all goals reached"
        return "\n".join([*grid, f"{due}; steps: {self._steps}, {needed(self._optimum)}"])

    def _checked(self, period: object, others: str = "") -> int:
        periods = len(self._layouts)
        if isinstance(period, bool) or not isinstance(period, (int, np.integer)) or not 0 <= period < periods:
            raise ConfigError.at("period", period, f"should be a whole number from 0 to {periods - 1}{others}")
        return int(period)

    def _enter(self, period: int) -> None:
        """Switch to the layout of a period."""
        layout = self._layouts[period : period + 1]
        codes = observation_codes(self.point, layout[:, 1:])[0]
        _, first, inverse = np.unique(codes, return_index=True, return_inverse=True)
        # The kernel numbers rows by the first occurrence of their code.
        rows = np.argsort(np.argsort(first))[inverse].reshape(codes.shape)
        self._codes: list[list[int]] = codes.tolist()
        found = behaviour_of(self.point, layout[:, 1:], codes[np.newaxis])
        self._steps_of: list[list[list[int]]] = found.steps[:, 0].tolist()
        self._stops_of: list[list[list[bool]]] = found.stops[:, 0].tolist()
        self._marks: list[list[int]] = np.zeros_like(codes).tolist() if found.marks is None else found.marks[0].tolist()
        self._observations: list[list[int]] = rows.tolist() if self._by_row else self._codes
        self._optimum = optimal_steps(self._tables, layout)[0].item()
        paid = rewards_by_transition(self.point, self._tables, layout[:, 1:])[0] if is_paid(self.point.reward) else None
        self._paid: list[Any] | None = None if paid is None else paid.tolist()
        self.period = period
        self.layout: tuple[int, ...] = tuple(layout[0].tolist())

    def _begin(self) -> None:
        self._cell = self.layout[0]
        self._reached = self._steps = 0

    def _step(self, direction: int) -> float:
        """Make one step and return its reward."""
        rules, goals = self._tables.rules, self.layout[1:]
        before, reached, outcome = self._cell, self._reached, 0
        if self._tables.outcomes is None or direction == WAIT:
            self._cell = self._next_cell[direction][before]
        else:
            cells, probabilities = (table[direction, before] for table in self._tables.outcomes)
            outcome = int(self.np_random.choice(len(cells), p=probabilities))
            self._cell = int(cells[outcome])
        self._steps += 1
        reward = rules.step_reward
        if self._cell == goals[self._reached]:
            self._reached += 1
            reward = rules.final_goal_reward if self._reached == len(goals) else rules.sub_goal_reward
        elif self._cell in goals:
            reward = rules.out_of_order_reward
        return reward if self._paid is None else self._paid[reached][direction][before][outcome]

    def _ended(self) -> bool:
        return self._reached == self.point.task.goals or self._steps == self._tables.rules.max_steps

    def _return(self, rewards: list[float], limit: int) -> float:
        """Return the return of an action with these rewards."""
        rules = self._tables.rules
        if limit > 1 and rules.printed_msa_reward:
            rewards = [rewards[0]] * (len(rewards) + 1)
        gain, discount = 0.0, 1.0
        for reward in rewards:
            gain += discount * reward
            discount *= rules.gamma
        return gain

    def _observe(self) -> int:
        return self._at(self._observations)

    def _at(self, table: list[list[_Entry]]) -> _Entry:
        """Return the entry of a table by success counter and cell."""
        return table[self._counter][self._cell]

    @property
    def _counter(self) -> int:
        """The success counter of the observation; the final goal has none, and there it is that of the last goal."""
        return min(self._reached, self.point.task.goals - 1)

    def _info(self) -> dict[str, Any]:
        return {
            "period": self.period,
            "code": self._codes[self._counter][self._cell],
            "moves": self._steps,
            "reached": self._reached,
            "optimum": self._optimum,
        }


def _code_count(point: DesignPoint) -> int:
    """Return an upper bound for the number of observation codes."""
    if isinstance(point.representation, SizedRepresentation):
        size: int = point.representation.spanned_size(point.world, point.task.goals)
        return min(size, _LARGEST_CODE)
    return _LARGEST_CODE


gymnasium.register(id=ID, entry_point="rl_design_space.environment:OrderedGoals")
