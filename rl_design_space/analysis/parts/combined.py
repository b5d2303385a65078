"""Parts made of parts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts.data import Data, Part
from rl_design_space.analysis.parts.ranged import Text
from rl_design_space.analysis.tested import Tested, all_of, any_of

_Parts = Annotated[tuple[Part, ...], Field(strict=False, min_length=2)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class AllOf:
    """Parts that must all hold.

    Attributes:
        what: description of what they say together.
        parts: each an option of `analysis.parts`.
    """

    what: Text
    parts: _Parts

    def test(self, data: Data) -> Tested:
        return all_of(self.what, [part.test(data) for part in self.parts])

    def refused(self) -> tuple[float, ...]:
        """Return the paper's own numbers that one of the ranges does not admit."""
        return tuple(number for part in self.parts for number in part.refused())


@dataclass(frozen=True, kw_only=True, config=STRICT)
class AnyOf:
    """Parts of which one must hold.

    Attributes:
        what: description of what they say together.
        parts: each an option of `analysis.parts`.
    """

    what: Text
    parts: _Parts

    def test(self, data: Data) -> Tested:
        return any_of(self.what, [part.test(data) for part in self.parts])

    def refused(self) -> tuple[float, ...]:
        """Return the paper's own numbers that a range does not admit, if that is so for every part."""
        refused = [part.refused() for part in self.parts]
        return tuple(number for numbers in refused for number in numbers) if all(refused) else ()
