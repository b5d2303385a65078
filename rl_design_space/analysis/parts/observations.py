"""Parts about what representations observe, without any learning."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts.data import Data
from rl_design_space.analysis.parts.ranged import Ranged
from rl_design_space.analysis.tested import Tested, exact
from rl_design_space.design import Representation, Torus, World, cell_count


@dataclass(frozen=True, kw_only=True, config=STRICT)
class KnownObservations(Ranged):
    """Share of the observations of a world that a smaller one has as well, over all layouts with one goal; exact.

    Attributes:
        representation: an option, e.g. `{_target_: rl_design_space.design.Direction}`.
        sizes: sizes of the smaller and of the larger world.
    """

    representation: Representation
    sizes: Annotated[tuple[int, int], Field(strict=False)]

    def test(self, data: Data) -> Tested:
        known, met = (self._observations(Torus(size=size)) for size in self.sizes)
        return exact(self.what, len(met & known) / len(met), *self.range)

    def _observations(self, world: World) -> set[int]:
        goals = np.arange(cell_count(world))[:, np.newaxis]
        return set(np.unique(self.representation.observation(world, goals)).tolist())
