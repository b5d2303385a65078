"""A representation that leaves out attributes of another one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.identity import full_name
from rl_design_space.design.observing import Attribute, AttributedRepresentation, FittedRepresentation, Representation
from rl_design_space.design.representation import COUNTER, Direction
from rl_design_space.design.world import World, cell_count
from rl_design_space.errors import ConfigError

_LARGEST_CODE = 2**63 - 1


def _tuple(values: Any) -> Any:
    return tuple(values) if isinstance(values, list) else values


def _built(representation: Any) -> Any:
    if isinstance(representation, (type, str)):
        raise ValueError("should be built, as Direction() is; names are for config files and the command line")
    return representation


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Without:
    """Another representation, of which the agent does not observe some attributes.

    The attributes of a representation are the parts of its observations: `counter`, the success counter; `x` and `y`,
    the agent's cell or block; `goal1`, `goal2`, …, what is observed of each goal. With none left out, it learns as the
    other representation does.

    Attributes:
        of: the other representation; in YAML its name, or its `_target_` and values.
        leave_out: names of the attributes that are left out.
        counters: success counters at which they are left out; at all of them if there is none here.
    """

    of: Annotated[Representation, BeforeValidator(_built, json_schema_input_type=str | dict[str, Any])] = Direction()
    leave_out: Annotated[tuple[str, ...], BeforeValidator(_tuple, json_schema_input_type=list[str])] = ()
    counters: Annotated[
        tuple[Annotated[int, Field(ge=0)], ...], BeforeValidator(_tuple, json_schema_input_type=list[int])
    ] = ()

    def check(self, world: World, n_goals: int) -> None:
        if isinstance(self.of, FittedRepresentation):
            self.of.check(world, n_goals)
        if self.counters and COUNTER in self.leave_out:
            raise ConfigError.at(
                "representation.counters", list(self.counters), f"an agent without {COUNTER} cannot know them; use []"
            )
        if late := [counter for counter in self.counters if counter >= n_goals]:
            raise ConfigError.at(
                "representation.counters", late, f"with {n_goals} goals the success counter is 0 to {n_goals - 1}"
            )
        self._all(world, np.arange(n_goals))

    def observation(self, world: World, goals: IntArray) -> NDArray[np.int64]:
        n_goals = goals.shape[-1]
        everywhere = not self.counters
        counter = np.arange(n_goals)[:, np.newaxis]
        kept = {
            name: each for name, each in self._all(world, goals).items() if not (everywhere and name in self.leave_out)
        }
        if math.prod(each.base for each in kept.values()) > _LARGEST_CODE:
            raise ValueError(f"task.goals={n_goals}: these attributes need codes of more than 64 bits; use fewer goals")
        codes = np.zeros((*goals.shape[:-1], n_goals, cell_count(world)), dtype=np.int64)
        for name, each in kept.items():
            is_left_out = np.isin(counter, self.counters) & (name in self.leave_out)
            codes = codes * each.base + np.where(is_left_out, 0, each.values)
        return codes

    def _all(self, world: World, goals: IntArray) -> Mapping[str, Attribute]:
        """Return all attributes of the other representation.

        Raises:
            ConfigError: it does not name its attributes, or one that is left out is not among them.
        """
        if not isinstance(self.of, AttributedRepresentation):
            name = full_name(type(self.of))
            raise ConfigError(f"representation.of: {name} has no method attributes(), so none can be left out")
        found = self.of.attributes(world, goals)
        for name in self.leave_out:
            if name not in found:
                raise ConfigError(f"representation.leave_out: {ConfigError.unknown('attribute', name, found)}")
        return found
