"""Short names of runs: what differs between the points of a sweep, and what its command line says."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Protocol

from rl_design_space.config.overrides import OPTION_GROUPS, is_setting, with_absent
from rl_design_space.plan.differences import differing

_PERIODS = "task.periods"
#: Most parameters of a name; of more, only the unusual values are named.
_MOST = 6
#: Options that say nothing without the name of their choice.
_VAGUE = ("none", "default")
#: Names of a run that differs in nothing from others, or from most of them.
_DEFAULTS, _USUAL = "defaults", "usual choices"


class _Point(Protocol):
    @property
    def parameters(self) -> Mapping[str, Any]: ...


def typed_keys(overrides: Iterable[str]) -> tuple[str, ...]:
    """Return the parameters of points that overrides name, with those inside of a component that is typed whole."""
    return tuple(name for each in overrides if not is_setting(each) for name in _typed(each))


def _typed(override: str) -> Iterator[str]:
    key, _, value = override.partition("=")
    yield (name := key.lstrip("+~"))
    if value.startswith("{"):
        from rl_design_space.config.grammar import parse  # which reports do not need

        yield from _inner(name, parse([override])[0].value())


def _inner(key: str, value: Any) -> Iterator[str]:
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield f"{key}.{name}"
            yield from _inner(f"{key}.{name}", inner)


class RunNames:
    """Names of the runs of some points, such as `sectors k=0.1 end`.

    A name lists the choices in which the points differ, and those that were typed. Options stand for themselves, values
    follow the last part of their names. Where that is ambiguous among the points, the whole names are used: no two
    points have the same name. Of many choices, values that most of the points have are left out.

    Args:
        points: points whose names should differ.
        typed: parameters that are named although they may be the same in all points.
    """

    def __init__(self, points: Sequence[_Point], typed: Iterable[str] = ()) -> None:
        self._points = points
        self._typed = tuple(typed)

    def name(self, parameters: Mapping[str, Any]) -> str:
        """Return the name of the run of a point.

        Args:
            parameters: of the point, which may have another number of periods than was planned.
        """
        style = self._style
        shown, periods = style.shown, _text(parameters[_PERIODS])
        if _PERIODS not in shown and periods not in style.periods:
            shown = (*shown, _PERIODS)
        tokens = [style.token(name, _text(parameters[name])) for name in shown if name in parameters]
        return " ".join(filter(None, tokens)) or (_USUAL if tokens else _DEFAULTS)

    @cached_property
    def _style(self) -> _Style:
        points = with_absent([_texts(planned.parameters) for planned in self._points])
        known = dict.fromkeys(name for point in points for name in point)
        shown = {*differing(points), *self._typed}
        groups = list(dict.fromkeys(_group(name) for name in known))
        names = [name for group in groups for name in known if name in shown and _group(name) == group]
        return _Style(tuple(names), points, self._typed)


class _Style:
    """How parameters and their values are written.

    Args:
        shown: the parameters of a name, in its order.
        points: their values.
        typed: parameters that are named whatever their value is.
    """

    def __init__(self, shown: tuple[str, ...], points: Sequence[Mapping[str, str]], typed: Sequence[str]) -> None:
        self.shown = shown
        self.periods = {point[_PERIODS] for point in points}
        last = Counter(name.rpartition(".")[2] for name in {*shown, _PERIODS})
        self._labels = {name: end if last[end := name.rpartition(".")[2]] == 1 else name for name in {*shown, _PERIODS}}
        self._usual = _usual(set(shown).difference(typed), points) if len(shown) > _MOST else frozenset()
        options = {(name, point[name]) for point in points for name in shown if name in OPTION_GROUPS and name in point}
        whole = Counter(option for _, option in options)
        short = Counter(_short(*option) for option in options)
        self._options = {
            (name, option): next(
                text
                for text, count in ((_short(name, option), short), (option, whole), (f"{name}={option}", None))
                if count is None or (count[text] == 1 and text not in _VAGUE)
            )
            for name, option in options
        }

    def token(self, name: str, value: str) -> str:
        """Return a parameter with its value; empty if that is the usual one."""
        if (name, value) in self._usual:
            return ""
        return self._options.get((name, value)) or f"{self._labels[name]}={value}"


def _usual(names: Iterable[str], points: Sequence[Mapping[str, str]]) -> frozenset[tuple[str, str]]:
    """Return parameters with the value that more than half of the points have."""
    counts = Counter((name, point[name]) for point in points for name in names if name in point)
    return frozenset(pair for pair, count in counts.items() if 2 * count > len(points))


def _texts(parameters: Mapping[str, Any]) -> dict[str, str]:
    return {name: _text(value) for name, value in parameters.items()}


def _text(value: Any) -> str:
    return str(value).replace(", ", ",") if isinstance(value, list | tuple) else str(value)


def _short(choice: str, option: str) -> str:
    """Return an option without the name of its choice: `end` for `reward=end_reward`."""
    for end in (f"_{choice}", f"_{choice}s"):
        if option.endswith(end) and option != end:
            return option.removesuffix(end)
    return option


def _group(name: str) -> str:
    return name.partition(".")[0]
