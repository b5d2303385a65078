"""The order of the values of parameters in reports: as asked for, else as the study lists them, else by size."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

from rl_design_space.errors import ConfigError
from rl_design_space.report.parameters import order, text
from rl_design_space.tracking.selection import comparable


class Ordering:
    """Keys to sort values of parameters by.

    Args:
        values: values of parameters in their order; other values follow, see `parameters.order`.
    """

    def __init__(self, values: Mapping[str, Sequence[Any]] | None = None) -> None:
        self._values = dict(values or {})
        self._places = {
            name: {value: place for place, value in enumerate(listed)} for name, listed in self._values.items()
        }

    @classmethod
    def of_study(cls, values: Mapping[str, Iterable[Any]]) -> Ordering:
        """Return the order in which a study lists the values of each parameter.

        Numbers ascend, unless the study lists them from the largest to the least: its blocks may each hold some.

        Args:
            values: of each parameter, as often as they occur; a list is one value.
        """
        found = {
            name: list(dict.fromkeys(comparable(each) for each in listed if each is not None))
            for name, listed in values.items()
        }
        return cls({name: listed for name, listed in found.items() if _is_meant(listed)})

    def replaced(self, wanted: Mapping[str, Sequence[Any]], known: Mapping[str, set[Any]]) -> Ordering:
        """Return the order with that of some parameters replaced.

        Args:
            wanted: values in the new order.
            known: all values of each parameter.

        Raises:
            ConfigError: nothing has one of the values.
        """
        for name, listed in wanted.items():
            for value in listed:
                if comparable(value) not in known[name]:
                    there = ", ".join(map(text, sorted(known[name], key=order)))
                    raise ConfigError.at(f"order.{name}", value, f"no run has this value (there is {there})")
        return Ordering({**self._values, **{name: list(map(comparable, listed)) for name, listed in wanted.items()}})

    def key(self, name: str, value: Any) -> tuple[int, float, str]:
        """Return a key to sort values of a parameter by."""
        place = self._places.get(name, {}).get(value)
        return order(value) if place is None else (-1, float(place), "")

    def keys(self, names: Iterable[str], values: Iterable[Any]) -> list[tuple[int, float, str]]:
        """Return a key to sort values of several parameters by."""
        return [self.key(name, value) for name, value in zip(names, values, strict=True)]


def _is_meant(values: Sequence[Any]) -> bool:
    """Return whether the order of values is more than that of blocks: texts, or numbers that descend."""
    numbers = [each for each in values if isinstance(each, int | float) and not isinstance(each, bool)]
    if len(numbers) < len(values):
        return True
    return len(numbers) > 1 and all(one > other for one, other in pairwise(numbers))
