"""Plan points that were built in Python: find the options and the overrides that describe them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from typing import Any

from rl_design_space.config.compose import Composer
from rl_design_space.config.grammar import as_override
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.design import DesignPoint
from rl_design_space.design.identity import full_name
from rl_design_space.errors import ConfigError
from rl_design_space.plan.component_check import ComponentCheck
from rl_design_space.plan.describe import flat
from rl_design_space.plan.plan import PlannedPoint


class Spelling:
    """Plans points that were built in Python as if they had been typed.

    A component is described by the option of the same class that differs from it in the fewest values. One that no
    option describes is named by its class: its points are recorded like all others, but only Python can learn them.

    Args:
        composer: composes the options.
    """

    def __init__(self, composer: Composer) -> None:
        self._composer = composer
        self._check = ComponentCheck()
        self._built: dict[str, Mapping[str, Any]] = {}
        self._found: dict[tuple[str, Any], tuple[str, tuple[str, ...]]] = {}

    def __call__(self, point: DesignPoint, studies: tuple[str, ...] = ()) -> PlannedPoint:
        """Plan a point.

        Raises:
            ConfigError: a component breaks its contract, or a field of one is not a plain value.
        """
        self._check(point)
        options, overrides = {}, []
        for group in OPTION_GROUPS:
            options[group], values = self._spelt(group, getattr(point, group))
            if options[group] != self._defaults.options[group]:
                overrides.append(f"{group}={options[group]}")
            overrides += values
        for field in ("task", "seed"):
            overrides += _differences(field, getattr(point, field), self._defaults.values[field])
        return PlannedPoint.of(point, options, tuple(overrides), studies)

    @cached_property
    def _defaults(self) -> Any:
        return self._composer.parts(())

    def _spelt(self, group: str, component: Any) -> tuple[str, tuple[str, ...]]:
        """Return the option that describes a component, and the overrides of its values."""
        key = (group, component)
        if key not in self._found:
            options = self._options(group)
            named = {
                name: _differences(group, component, option)
                for name, option in options.items()
                if type(option) is type(component) and flat(group, option).keys() == flat(group, component).keys()
            }
            name = min(named, key=lambda each: len(named[each]), default=full_name(type(component)))
            self._found[key] = name, named.get(name, ())
        return self._found[key]

    def _options(self, group: str) -> Mapping[str, Any]:
        """Return the options of a choice that can be built, the default first."""
        if group not in self._built:
            default = self._defaults.options[group]
            built = {default: self._defaults.values[group]}
            for name in self._composer.options(group):
                with suppress(ConfigError):  # one that has to be given values, or cannot be used
                    built.setdefault(name, self._composer.parts([f"{group}={name}"]).values[group])
            self._built[group] = built
        return self._built[group]


def _differences(key: str, component: Any, option: Any) -> tuple[str, ...]:
    """Return an override for each value in which a component differs from another one of its class."""
    return tuple(_changed(flat(key, component), flat(key, option)))


def _changed(values: Mapping[str, Any], others: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        if value != others[name]:
            yield as_override(name, value)
