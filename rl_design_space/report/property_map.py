"""Properties of representations as a graded table, without any learning."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.aliasing import aliasing_by_layout
from rl_design_space.analysis.properties import Places, properties_by_layout
from rl_design_space.analysis.statistics import Estimate, mean_estimate
from rl_design_space.design import GoalReward, QLearning, Representation, SizedRepresentation, Torus, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.learning.streams import layouts
from rl_design_space.report.definitions import Found
from rl_design_space.report.graded_table import GradedTable, Measured
from rl_design_space.report.runs import Runs


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PropertyMap(GradedTable):
    """Properties of representations on random layouts, without any learning.

    Quantities: states_each, as how many states a state is seen; aliased, share of states that are seen as others
    without a common optimal move; observations, how many the representation can make, or, if it has no `spanned_size`,
    how many occur in the layouts; right_elsewhere, share of states of another layout and of a larger grid in which the
    best move for the observation is optimal; next_unknown, value_lost and shared, see `analysis.aliasing`.

    Attributes:
        representations: by name, each an option.
        size: side of the torus.
        larger: side of the torus that a Q-matrix is to be carried to.
        goals: of a layout.
        layouts: how many layouts are drawn.
        reward: rewards of the task, for its optimal values.
        learner: discount and reward of goals that are not due, for the optimal values.
        readings: representations that differ, by the name of a reading under which other definitions are measured.
    """

    shows: str = "Measured grade of each property of each representation, and the published grade"
    representations: dict[str, Any]
    size: Annotated[int, Field(ge=2)]
    larger: Annotated[int, Field(ge=2)]
    goals: Annotated[int, Field(ge=1)]
    layouts: Annotated[int, Field(ge=2)]
    reward: Any = GoalReward()
    learner: QLearning = QLearning()
    readings: dict[str, dict[str, Any]] = Field(default_factory=dict)

    @property
    def quantities(self) -> tuple[str, ...]:
        return ("states_each", "aliased", "observations", "right_elsewhere", "next_unknown", "value_lost", "shared")

    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        """Return the quantities of each representation.

        Raises:
            ConfigError: one of them is not a representation.
        """
        return {name: self._measured(name, each) for name, each in self._estimated.items()}

    def found(self, runs: Runs) -> Mapping[str, Found]:
        """Return the quantities of each representation, by reading.

        Raises:
            ConfigError: one of them is not a representation.
        """
        return {
            reading: {**self._estimated, **{name: self._estimates(name, each) for name, each in others.items()}}
            for reading, others in (self.readings or {"": {}}).items()
        }

    def how(self) -> list[str]:
        where = (
            f"Exact on {self.layouts} random layouts of {self.goals} goals on a {self.size}×{self.size} torus; the "
            f"larger grid is {self.larger}×{self.larger}. A state is a cell and a success counter; whether a move is "
            "optimal is found by breadth-first search."
        )
        return [where]

    @cached_property
    def _places(self) -> tuple[Places, Places]:
        """Layouts on the torus, and on the larger one."""
        worlds = Torus(size=self.size), Torus(size=self.larger)
        here, there = (Places.of(each, layouts(0, cell_count(each), self.goals, self.layouts)) for each in worlds)
        return here, there

    @cached_property
    def _estimated(self) -> Mapping[str, Mapping[str, Estimate]]:
        """Quantities of each representation."""
        return {name: self._estimates(name, each) for name, each in self.representations.items()}

    def _measured(self, name: str, each: Mapping[str, Estimate]) -> Mapping[str, Measured]:
        sized = isinstance(self.representations[name], SizedRepresentation)
        size = f"{each['observations'].value:,.0f} observations"
        texts = {
            "states_each": f"a state is seen as\n{each['states_each'].value:.1f} states",
            "aliased": f"{each['aliased'].value:.0%} of states have\nno agreed move",
            "observations": size if sized else f"{size}\nin {self.layouts} layouts",
            "right_elsewhere": (
                f"{each['other_goals'].value:.0%} right with other goals,\n"
                f"{each['larger_grid'].value:.0%} on a larger grid"
            ),
            "next_unknown": f"the next observation has\n{each['next_unknown'].value:.2f} bits left",
            "value_lost": f"{each['value_lost'].value:.0%} of the variance\nof values lost",
            "shared": f"{each['shared'].value:.0%} of states share\ntheir observation",
        }
        return {quantity: Measured(each[quantity].value, text, *each[quantity][1:]) for quantity, text in texts.items()}

    def _estimates(self, name: str, representation: Any) -> Mapping[str, Estimate]:
        """Return the quantities with intervals over layouts; the number of observations is exact.

        Raises:
            ConfigError: it is not a representation.
        """
        if not isinstance(representation, Representation):
            expected = "should be a representation: an option whose class has observation(world, goals)"
            raise ConfigError(f"study.report.representations.{name}={type(representation).__name__}: {expected}")
        here, _ = self._places
        by_layout = properties_by_layout(representation, *self._places)
        by_layout["right_elsewhere"] = (by_layout["other_goals"] + by_layout["larger_grid"]) / 2
        by_layout |= aliasing_by_layout(representation, here.world, here.layouts, self.reward, self.learner)
        if isinstance(representation, SizedRepresentation):
            size = float(representation.spanned_size(here.world, self.goals))
        else:
            size = float(len(np.unique(representation.observation(here.world, here.layouts[:, 1:]))))
        estimates = {quantity: mean_estimate(values) for quantity, values in by_layout.items()}
        return {**estimates, "observations": Estimate(size, size, size)}
