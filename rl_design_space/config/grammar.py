"""Parse overrides with Hydra's grammar, and check what can be checked before anything is composed."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Sequence
from decimal import Decimal
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.overrides_visitor import HydraErrorListener
from hydra.core.override_parser.types import (
    ChoiceSweep,
    Glob,
    Override,
    Quote,
    QuotedString,
    RangeSweep,
    Sweep,
    ValueType,
)
from hydra.errors import HydraException, OverrideParseException
from hydra.grammar.gen.OverrideLexer import CommonTokenStream, InputStream, OverrideLexer  # type: ignore[attr-defined]
from hydra.grammar.gen.OverrideParser import OverrideParser
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from rl_design_space._secrets import without_secrets
from rl_design_space._yaml import as_yaml
from rl_design_space.config.overrides import OPTION_GROUPS, is_override
from rl_design_space.errors import ConfigError

_GROUPS = frozenset((*OPTION_GROUPS, "tracking", "study", "hydra"))
LOOK = "overrides look like key=value, e.g. exploration.k=0.02"
_BRACKETS = {"(": ")", "[": "]", "{": "}"}
#: Text that needs no quotes in an override: it is not read as a number, nor as one of the words of the grammar.
_PLAIN = re.compile(r"(?!(?:true|false|null|nan|inf)$)[a-z_][\w./-]*", re.IGNORECASE)


def parse(overrides: Sequence[str], parser: OverridesParser | None = None) -> list[Override]:
    """Parse and check overrides.

    Args:
        overrides: as on the command line.
        parser: the parser; a new one, which cannot enumerate a glob, if None.

    Raises:
        ConfigError: an override cannot be parsed, has a value where the name of an option is needed, or sweeps over a
            range that has no end.
    """
    try:
        parsed: list[Override] = (parser or OverridesParser.create()).parse_overrides(list(overrides))
    except OverrideParseException as error:
        raise not_understood(error.override) from error
    for override in parsed:
        _check_nesting(override)
        _check_option(override)
        _check_range(override)
    return parsed


def not_understood(text: str) -> ConfigError:
    """Return an error for an override that Hydra's grammar does not accept, with the character that is the matter."""
    key, equals, value = text.partition("=")
    if not is_override(text):
        return ConfigError(without_secrets(f"{text}: not an override; {LOOK}"))
    place = _first_problem(text)
    if place is None:  # the grammar accepts it, a function does not
        return ConfigError(without_secrets(f"{text}: {_refusal(text)}"))
    unclosed = _unclosed(text)
    if place >= len(text) and unclosed is not None:
        problem = f'character {unclosed + 1}, "{text[unclosed]}", is not closed'
    elif place >= len(text):
        problem = f"ends too early; {LOOK}"
    else:
        problem = f'character {place + 1}, "{text[place]}", cannot be used here'
    quoted = f"{key}={_quoted(value)}"
    if equals and _first_problem(quoted) is None:
        problem += f"; quoted, it is text: {shlex.quote(quoted)}"
    return ConfigError(without_secrets(f"{text}: {problem}"))


def sweep_size(override: Override) -> int:
    """Return how many values an override lists, without listing those of a range; 1 if it is no sweep."""
    value = override.value()
    if isinstance(value, RangeSweep):
        values = value.range()
        if isinstance(values, range):
            return max(0, -((values.start - values.stop) // values.step))  # `len` has a maximum
        start, stop, step = (Decimal(number) for number in (values.start, values.stop, values.step))
        return max(0, math.ceil((stop - start) / step))
    return sum(1 for _ in override.sweep_iterator()) if override.is_discrete_sweep() else 1


def _check_nesting(override: Override) -> None:
    """Refuse sweeps inside of values; Hydra takes them for values.

    Raises:
        ConfigError: an override such as `seed=range(0,3),7`.
    """
    value = override.value()
    inner = value.list if isinstance(value, ChoiceSweep) else value
    if isinstance(inner, (list, dict)) and _holds_sweep(inner):
        raise ConfigError(f"{override.input_line}: a sweep cannot be one of several values; list its values instead")


def _holds_sweep(value: Any) -> bool:
    if isinstance(value, (list, dict)):
        return any(map(_holds_sweep, value.values() if isinstance(value, dict) else value))
    return isinstance(value, (Sweep, Glob))


def _check_option(override: Override) -> None:
    """Refuse values where the name of an option is needed; the errors of Hydra do not name the key.

    Raises:
        ConfigError: an override such as `world=10`.
    """
    key = override.key_or_group
    if not (key in _GROUPS or key.startswith("hydra/")):
        return
    nothing = override.is_delete() or (key == "study" and not override.is_add())
    # `~world` has no value, and `study=null` chooses no study.
    if not all(_names_options(value) or (nothing and value is None) for value in _elements(override)):
        raise ConfigError(f"{override.input_line}: name exactly one option")


def _elements(override: Override) -> list[Any]:
    """Return the value of an override, or the values that it lists; none if they are names by themselves."""
    if override.value_type == ValueType.ELEMENT or override.value_type is None:
        return [override.value()]
    if override.value_type in (ValueType.CHOICE_SWEEP, ValueType.SIMPLE_CHOICE_SWEEP):
        return [Override._convert_value(value) for value in override.sweep_iterator()]
    return [] if override.value_type == ValueType.GLOB_CHOICE_SWEEP else [math.nan]


def _names_options(value: Any) -> bool:
    """Return whether a value names an option, or several, as Hydra accepts them."""
    if isinstance(value, dict):
        return True  # the content of an option
    names = map(_resolved, value if isinstance(value, list) else [value])
    return all(isinstance(name, str) and name not in ("", "???") for name in names)


def _resolved(value: Any) -> Any:
    """Return the value of an interpolation that needs no config, such as `${oc.env:WORLD,torus}`; others unchanged."""
    if not isinstance(value, str) or "${" not in value:
        return value
    try:
        return OmegaConf.create({"value": value}).value
    except OmegaConfBaseException:
        return value


def _check_range(override: Override) -> None:
    """Refuse ranges without an end.

    Raises:
        ConfigError: the step is 0, or a number is not finite.
    """
    value = override.value()
    if not isinstance(value, RangeSweep):
        return
    if not all(number is not None and math.isfinite(number) for number in (value.start, value.stop, value.step)):
        raise ConfigError(f"{override.input_line}: a range should begin and end at a number, with a number as its step")
    if value.step == 0:
        raise ConfigError(f"{override.input_line}: the step of a range should not be 0")


class _First(HydraErrorListener):
    """Keeps the place of the first error."""

    place: int | None = None

    def syntaxError(self, recognizer: Any, symbol: Any, line: int, column: int, message: str, error: Any) -> None:  # noqa: N802
        if self.place is None:
            self.place = getattr(error, "startIndex", None) if symbol is None else symbol.start


def _first_problem(text: str) -> int | None:
    """Return the index of the character at which the grammar stops, or None if it accepts the text."""
    first = _First()
    lexer = OverrideLexer(InputStream(text))
    parser = OverrideParser(CommonTokenStream(lexer))
    for recognizer in (lexer, parser):
        recognizer.removeErrorListeners()
        recognizer.addErrorListener(first)
    parser.override()  # type: ignore[no-untyped-call]
    return first.place


def _refusal(text: str) -> str:
    """Return why a function of Hydra's grammar does not accept its arguments."""
    try:
        OverridesParser.create().parse_override(text)
    except HydraException as error:
        return " ".join(re.sub(r"^\w+ while evaluating '.*?': ", "", str(error), flags=re.DOTALL).split())
    return LOOK


def _unclosed(text: str) -> int | None:
    """Return the index of the last bracket that is not closed, or None."""
    opened: list[int] = []
    for index, character in enumerate(text):
        if character in _BRACKETS:
            opened.append(index)
        elif opened and character == _BRACKETS[text[opened[-1]]]:
            opened.pop()
    return opened[-1] if opened else None


def as_override(key: str, value: Any) -> str:
    """Return the override that gives a key this value; text is quoted where it needs to be."""
    return f"{key}={_quoted(value) if isinstance(value, str) and not _PLAIN.fullmatch(value) else as_yaml(value)}"


def _quoted(value: str) -> str:
    return QuotedString(value, Quote.double).with_quotes()
