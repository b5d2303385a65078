"""Variations of a study: readings that change its points, singly and combined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import combinations
from typing import Annotated, Any, NamedTuple

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.design import DesignPoint
from rl_design_space.errors import ConfigError

#: Values by key, as on the command line: {"learner.explore": "all"}.
Values = Annotated[dict[str, Any], Field(strict=False)]
Names = Annotated[tuple[str, ...], Field(strict=False, min_length=1)]


class Combination(NamedTuple):
    """Readings that are taken together.

    Attributes:
        readings: their names, in the order in which the study lists them.
        values: what they change.
    """

    readings: tuple[str, ...]
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        return " + ".join(self.readings)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Variations:
    """Readings that change the points of a study, each alone and combined with others.

    Readings that change the same key contradict each other and are not combined. A combination changes those points
    only that have all of its keys.

    Attributes:
        readings: the values that each reading gives to a point, by name.
        order: largest number of readings that are combined: 1 for each alone, 2 for pairs as well.
        also: combinations of any size beside these.
        around: combinations beside these, also with each other reading added.
        values: values of every changed point, e.g. {task.periods: 100}.
    """

    readings: dict[str, Values]
    order: Annotated[int, Field(ge=1, le=4)] = 1
    also: Annotated[tuple[Names, ...], Field(strict=False)] = ()
    around: Annotated[tuple[Names, ...], Field(strict=False)] = ()
    values: Values = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = DesignPoint.__dataclass_fields__
        for reading, values in {**self.readings, "": self.values}.items():
            for key in values:
                if key.partition(".")[0] not in known:
                    where = f"reading {reading}" if reading else "values"
                    raise ConfigError(f"{where}: {ConfigError.unknown('key of points', key, known)}")
        for key, names in [*(("also", each) for each in self.also), *(("around", each) for each in self.around)]:
            for name in names:
                if name not in self.readings:
                    raise ConfigError(f"{key}: {ConfigError.unknown('reading', name, self.readings)}")
            if self._joined(names) is None:
                raise ConfigError(f"{key}: {', '.join(names)}: should be readings that change different keys")

    @cached_property
    def combinations(self) -> Sequence[Combination]:
        """All combinations, each once, from the single readings on."""
        acting = [name for name, values in self.readings.items() if values]
        chosen: list[tuple[str, ...]] = [(name,) for name in self.readings]
        for size in range(2, self.order + 1):
            chosen += combinations(acting, size)
        chosen += self.also
        for names in self.around:
            chosen += [names, *((*names, other) for other in acting if other not in names)]
        place = {name: number for number, name in enumerate(self.readings)}
        distinct = dict.fromkeys(tuple(sorted(set(names), key=place.__getitem__)) for names in chosen)
        found = [Combination(names, values) for names in distinct if (values := self._joined(names)) is not None]
        return sorted(found, key=lambda combination: len(combination.readings))

    def _joined(self, names: Sequence[str]) -> Mapping[str, Any] | None:
        """Return what these readings change together; None if two of them change the same key."""
        joined: dict[str, Any] = {}
        for name in dict.fromkeys(names):
            if joined.keys() & self.readings[name].keys():
                return None
            joined |= self.readings[name]
        return joined


def variations_of(node: Any) -> Variations | None:
    """Return the variations in a study's file; None if it has none.

    Raises:
        ConfigError: they are not a mapping with the fields of `Variations`.
    """
    if node is None:
        return None
    if not isinstance(node, Mapping):
        raise ConfigError("variations: should be a mapping with readings, e.g. {readings: {NAME: {KEY: VALUE}}}")
    try:
        return construct(Variations, node, "variations")
    except ConfigError as error:
        text = str(error)
        raise error if text.startswith("variations") else ConfigError(f"variations: {text}") from error
