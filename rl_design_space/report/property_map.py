"""Properties of representations as a graded table, without any learning."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.properties import properties
from rl_design_space.design import Representation, SizedRepresentation, Torus, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.learning.streams import layouts
from rl_design_space.report.base import Frames
from rl_design_space.report.graded_table import GradedTable, Measured
from rl_design_space.report.runs import Runs


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PropertyMap(GradedTable):
    """Properties of representations on random layouts, without any learning.

    Quantities: states_each, as how many states a state is seen; aliased, share of states that are seen as others
    without a common optimal move; observations, how many the representation can make, or, if it has no `spanned_size`,
    how many occur in the layouts; right_elsewhere, share of states of another layout and of a larger grid in which the
    best move for the observation is optimal.

    Attributes:
        representations: by name, each an option.
        size: side of the torus.
        larger: side of the torus that a Q-matrix is to be carried to.
        goals: of a layout.
        layouts: how many layouts are drawn.
    """

    shows: str = "Measured grade of each property of each representation, and the published grade"
    representations: dict[str, Any]
    size: Annotated[int, Field(ge=2)]
    larger: Annotated[int, Field(ge=2)]
    goals: Annotated[int, Field(ge=1)]
    layouts: Annotated[int, Field(ge=2)]

    @property
    def quantities(self) -> tuple[str, ...]:
        return ("states_each", "aliased", "observations", "right_elsewhere")

    def measured(self, runs: Runs) -> Mapping[str, Mapping[str, Measured]]:
        """Return the quantities of each representation.

        Raises:
            ConfigError: one of them is not a representation.
        """
        return {name: self._measured(name, each) for name, each in self.representations.items()}

    def text(self, frames: Frames) -> list[str]:
        """Return the cells, the rules of their grades, and where they were measured."""
        where = (
            f"Exact on {self.layouts} random layouts of {self.goals} goals on a {self.size}×{self.size} torus; the "
            f"larger grid is {self.larger}×{self.larger}. A state is a cell and a success counter; whether a move is "
            "optimal is found by breadth-first search."
        )
        return [*super().text(frames), where]

    def _measured(self, name: str, representation: Any) -> Mapping[str, Measured]:
        if not isinstance(representation, Representation):
            expected = "should be a representation: an option whose class has observation(world, goals)"
            raise ConfigError(f"study.report.representations.{name}={type(representation).__name__}: {expected}")
        world, larger = Torus(size=self.size), Torus(size=self.larger)
        here, there = (layouts(0, cell_count(each), self.goals, self.layouts) for each in (world, larger))
        found = properties(representation, world, larger, here, there)
        if isinstance(representation, SizedRepresentation):
            size = representation.spanned_size(world, self.goals)
            counted = f"{size:,} observations"
        else:
            size = len(np.unique(representation.observation(world, here[:, 1:])))
            counted = f"{size:,} observations\nin {self.layouts} layouts"
        texts = {
            "states_each": (found.states_each, f"a state is seen as\n{found.states_each:.1f} states"),
            "aliased": (found.aliased, f"{found.aliased:.0%} of states have\nno agreed move"),
            "observations": (float(size), counted),
            "right_elsewhere": (
                (found.other_goals + found.larger_grid) / 2,
                f"{found.other_goals:.0%} right with other goals,\n{found.larger_grid:.0%} on a larger grid",
            ),
        }
        return {quantity: Measured(*each) for quantity, each in texts.items()}
