"""Three factorials of more than 1,000 points, and their full sweeps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path

import numpy as np

from rl_design_space._arrays import FloatArray
from rl_design_space.config.compose import shipped_config
from rl_design_space.learning import simulate
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import plan_overrides

#: The seed of all numbers that are shown; the race was developed on seed 0 of the first two studies.
SEED, PERIODS = 1, 300
_REPRESENTATIONS, _REWARDS = ("ad_hoc", "distance", "direction"), ("many_rewards", "each_success", "end_reward")

#: Choices of each study, and what all of its points have.
STUDIES: Mapping[str, tuple[Mapping[str, Sequence[str | float]], Sequence[str]]] = {
    "choices": (
        {
            "representation": _REPRESENTATIONS,
            "msa": ("none", "length_2", "length_3", "length_5", "lengths_2_3", "lengths_2_3_5"),
            "reward": _REWARDS,
            "exploration.k": (0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.5),
            "learner.alpha": (0.1, 0.3, 0.6),
        },
        ("exploration=linear", "task.trials=30"),
    ),
    "schedules": (
        {
            "representation": ("ad_hoc", "direction"),
            "exploration.l": (1.05, 1.1, 1.2, 1.5, 2),
            "exploration.start": (0.3, 0.6, 0.9),
            "learner.alpha": (0.1, 0.2, 0.4, 0.8),
            "learner.gamma": (0.8, 0.9, 0.95),
            "reward": _REWARDS,
        },
        ("exploration=exponential", "world.size=8", "task.trials=20"),
    ),
    "epsilons": (
        {
            "representation": _REPRESENTATIONS,
            "exploration.epsilon": (0.0, 0.02, 0.05, 0.1, 0.2, 0.3),
            "msa": ("none", "length_2", "length_3", "lengths_2_3", "lengths_2_3_5"),
            "learner.alpha": (0.1, 0.3, 0.6, 1.0),
            "reward": _REWARDS,
        },
        ("exploration=constant", "world.size=6", "task.goals=2", "task.trials=40"),
    ),
}


@dataclass(frozen=True)
class Sweep:
    """The full sweep of a study.

    Attributes:
        name: of the study.
        values: (periods, points) total steps; the last choice changes fastest.
        choices: values of each choice.
    """

    name: str
    values: FloatArray
    choices: Mapping[str, Sequence[str | float]]

    def number(self, chosen: Mapping[str, str | float | None]) -> int:
        """Return the number of the point with these values, of each choice one."""
        shape = [len(values) for values in self.choices.values()]
        indices = [list[object](values).index(chosen[name]) for name, values in self.choices.items()]
        return int(np.ravel_multi_index(indices, shape))


def full_sweep(name: str, folder: Path, report: Callable[[str], None], periods: int = PERIODS) -> Sweep:
    """Return the full sweep of a study; its numbers are kept in a file, because they take minutes.

    Args:
        name: of the study.
        folder: for the file.
        report: told what goes on.
        periods: of each point.
    """
    choices, given = STUDIES[name]
    file = folder / f"search_{name}_{periods}.npy"
    if not file.exists():
        axes = [f"{key}={','.join(map(str, values))}" for key, values in choices.items()]
        schedule, *others = given
        with shipped_config():
            plan = plan_overrides(
                [schedule, *axes, *others, f"task.periods={periods}", f"seed={SEED}"], Planner(), 10_000
            )
        assert len(plan) == prod(map(len, choices.values()))
        values = np.empty((periods, len(plan)))
        for number, planned in enumerate(plan):
            values[:, number] = simulate(planned.point, threads=1).total_steps
            if number % 100 == 0:
                report(f"{name}: {number:,} of {len(plan):,} points of the full sweep")
        folder.mkdir(parents=True, exist_ok=True)
        np.save(file, values)
    return Sweep(name, np.load(file), choices)
