"""Points of a study as readings change them, as overrides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.config.assemble import Parts
from rl_design_space.config.compose import Composer
from rl_design_space.config.overrides import OPTION_GROUPS, is_setting
from rl_design_space.errors import ConfigError
from rl_design_space.plan.grid import axes
from rl_design_space.plan.variations import Combination, Variations

#: Why a combination of readings is no point.
INAPPLICABLE = "the point has no such key"


class Varied:
    """The combinations of readings as they change points.

    A value that the command line gives is kept. Where a reading chooses another option, values of the point that this
    option does not have are left out.

    Args:
        variations: the readings and their combinations.
        more: overrides of the command line.
        composer: composes the options that readings choose.

    Raises:
        ConfigError: a reading has several values for a key.
    """

    def __init__(self, variations: Variations, more: Sequence[str], composer: Composer) -> None:
        self._composer = composer
        self._settings = list(filter(is_setting, more))
        self._kept = {_key(override) for override in more if not is_setting(override)}
        self._unused = {name: values for name, values in variations.readings.items() if values and not self._kept}
        self._options: dict[tuple[str, str], Any] = {}
        self._common = self._overrides("values", variations.values)
        self._combinations: list[tuple[Combination, Mapping[str, str]]] = []
        singles = {name: self._overrides(f"reading {name}", given) for name, given in variations.readings.items()}
        for combination in filter(lambda each: each.values, variations.combinations):
            changes = {key: text for name in combination.readings for key, text in singles[name].items()}
            self._combinations.append((combination, changes))

    @property
    def count(self) -> int:
        """Number of combinations."""
        return len(self._combinations)

    def __call__(self, parts: Parts, overrides: Sequence[str]) -> Iterator[tuple[str, ...] | None]:
        """Yield the overrides of a point under each combination; None where it does not have all of its keys.

        Args:
            parts: of the point.
            overrides: that the parts were composed from.
        """
        for combination, changes in self._combinations:
            chosen = {key: self._option(key, text) for key, text in changes.items() if key in OPTION_GROUPS}
            components = {**parts.values, **chosen}
            if not all(has_key(components, key) for key in changes):
                yield None
                continue
            for name in combination.readings:
                self._unused.pop(name, None)
            given = {
                key: override
                for override in overrides
                if (key := _key(override)).partition(".")[0] not in chosen or key in chosen or has_key(chosen, key)
            }
            yield tuple({**given, **changes, **self._common}.values())

    def check(self) -> None:
        """Refuse a reading that changes no point of the study; the command line may have narrowed it to such points.

        Raises:
            ConfigError: there is such a reading.
        """
        for name, values in self._unused.items():
            raise ConfigError(f"reading {name}: no point of this study has {', '.join(values)}; correct or remove it")

    def _overrides(self, place: str, values: Mapping[str, Any]) -> Mapping[str, str]:
        """Return an override for each key that the command line leaves free."""
        found = {}
        for key, value in values.items():
            (override, *others) = axes([f"{key}={as_yaml(value)}"], self._composer.parser)[key]
            if others:
                raise ConfigError(f"{place}: {ConfigError.at(key, value, 'should be one value')}")
            if key not in self._kept:
                found[key] = override
        return found

    def _option(self, group: str, override: str) -> Any:
        if (group, override) not in self._options:
            self._options[group, override] = self._composer.parts([*self._settings, override]).values[group]
        return self._options[group, override]


def has_key(components: Mapping[str, Any], key: str) -> bool:
    """Return whether a point with these components has a key, e.g. `exploration.k`."""
    first, *names = key.split(".")
    if first not in components:
        return False
    value = components[first]
    for name in names:
        if not is_dataclass(value) or name not in {field.name for field in fields(value)}:
            return False
        value = getattr(value, name)
    return True


def _key(override: str) -> str:
    return override.partition("=")[0].lstrip("+~")
