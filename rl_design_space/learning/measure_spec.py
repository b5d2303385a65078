"""Specifications of measures, as mappings in YAML and as text: `{steps_after: 30, statistic: median}`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, TypeAlias

from rl_design_space._yaml import as_yaml
from rl_design_space.errors import ConfigError

#: How a measure is named: its text form, or a mapping.
Spec: TypeAlias = "str | Mapping[str, Any]"

_TARGET, _STATISTIC = "_target_", "statistic"
#: Module and function of a user's own measure.
_OWN = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)+")
_NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?|[-+]?\.\d+([eE][-+]?\d+)?")


@dataclass(frozen=True)
class MeasureSpec:
    """A specification.

    Attributes:
        name: of a measure, or module and function of a user's own one.
        value: of the parameter that the measure is named with; None if left out.
        statistic: how the numbers of periods become one.
        parameters: further ones, of a user's own function.
    """

    name: str
    value: Any = None
    statistic: str = "mean"
    parameters: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_own(self) -> bool:
        """Whether it names a function of the user's own."""
        return _OWN.fullmatch(self.name) is not None

    @property
    def text(self) -> str:
        """The text form: `steps_after=30,statistic=median`."""
        named = {self.name: self.value, **dict(sorted(self.parameters.items()))}
        if self.statistic != "mean":
            named[_STATISTIC] = self.statistic
        return ",".join(name if value is None else f"{name}={_as_text(value)}" for name, value in named.items())


def parsed(spec: object) -> MeasureSpec:
    """Return what a name, a text form or a mapping says.

    Raises:
        ConfigError: it is none of them.
    """
    if isinstance(spec, str):
        return _of_text(spec)
    if isinstance(spec, Mapping) and spec:
        return _of_mapping(spec)
    raise ConfigError.at(
        "measure", spec, "should be a name, such as total_steps, or a mapping, such as {steps_after: 30}"
    )


@lru_cache(maxsize=256)
def _of_text(text: str) -> MeasureSpec:
    named: dict[str, Any] = {}
    for part in text.split(","):
        name, equals, value = part.strip().partition("=")
        if not name or (equals and not value) or name in named:
            expected = "should be a name, such as total_steps or steps_after=30,statistic=median"
            raise ConfigError.at("measure", text, expected)
        named[name] = _of_word(value) if equals else None
    return _of_mapping(named)


def _of_mapping(spec: Mapping[str, Any]) -> MeasureSpec:
    rest = {str(name): value for name, value in spec.items() if name != _TARGET}
    statistic = _statistic(rest.pop(_STATISTIC, "mean"))
    if _TARGET in spec:
        return MeasureSpec(str(spec[_TARGET]), None, statistic, rest)
    if not rest:
        raise ConfigError.at("measure", spec, "names a statistic but no measure")
    name = next(iter(rest))
    return MeasureSpec(name, rest.pop(name), statistic, rest)


def _statistic(value: Any) -> str:
    """Return the name of a statistic, which may be a mapping of one key: `{cvar: 5}`."""
    if isinstance(value, Mapping) and len(value) == 1:
        ((name, of),) = value.items()
        return f"{name}={_as_text(of)}"
    return str(value)


def _of_word(word: str) -> Any:
    """Return a value of the text form: a number, true, false, or else text."""
    if _NUMBER.fullmatch(word):
        number = float(word)
        return int(number) if word.lstrip("+-").isdecimal() else number
    return {"true": True, "false": False}.get(word, word)


def _as_text(value: Any) -> str:
    """Return a value in the text form.

    Raises:
        ConfigError: it would be read as something else.
    """
    text = f"{value:.15g}" if isinstance(value, float) else as_yaml(value)
    if isinstance(value, (Mapping, list, tuple)) or "," in text or (isinstance(value, str) and _of_word(text) != value):
        raise ConfigError.at("measure", value, "a parameter should be a number, true, false, or text without commas")
    return text
