"""Parameters of design points: their values as text and in order, and what may be averaged."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from rl_design_space.errors import ConfigError
from rl_design_space.plan.differences import differing

#: Runs that differ in this alone are repetitions of each other.
SEED = "seed"
#: Number of periods; runs that differ in this alone are samples of different size.
PERIODS = "task.periods"


def text(value: Any) -> str:
    """Return a value of a parameter as text; frames have NaN where a column of numbers lacks one."""
    if value is None or value != value:
        return "–"
    return f"{value:g}" if isinstance(value, float) else str(value)


def label(names: Collection[str], values: Iterable[Any]) -> str:
    """Return values of parameters as they are written on the command line."""
    return " ".join(f"{name}={text(value)}" for name, value in zip(names, values, strict=True))


def order(value: Any) -> tuple[int, float, str]:
    """Return a key to sort values of a parameter by: numbers by their size, then texts, then missing values."""
    if value is None:
        return (2, 0.0, "")
    return (0, float(value), "") if isinstance(value, int | float) else (1, 0.0, str(value))


def check_averaged(points: Sequence[Mapping[str, Any]], where: str, advice: str, mean: bool) -> None:
    """Refuse to average runs that differ in more than their seed, unless the user asks for it.

    Args:
        points: parameters of each run.
        where: name of the cell or line that they share, for the message.
        advice: what else the user can do.
        mean: whether the user asks for the mean.

    Raises:
        ConfigError: they differ; the parameters are named.
    """
    others = [name for name in differing(points) if name != SEED]
    if others and not mean:
        raise ConfigError(
            f"{', '.join(others)}: {len(points)} runs of one {where} differ in this; {advice}, choose with --where, "
            "or take their mean with --mean"
        )
