"""Validating arrays that components return, because compiled code does not check its indices."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design.identity import full_name
from rl_design_space.errors import ConfigError

Scalar = TypeVar("Scalar", bound=np.generic)
#: The largest numbers of their types; a limit that is one of them is none.
LARGEST = float(np.finfo(np.float64).max)
LARGEST_CODE = 2**63 - 1


def checked_table(
    choice: str,
    component: object,
    method: str,
    table: object,
    shape: tuple[int, ...],
    dtype: type[Scalar],
    low: float,
    high: float,
) -> NDArray[Scalar]:
    """Return an array that a component has returned, if it is what its contract says.

    Args:
        choice: name of the choice, for messages.
        component: that returned it.
        method: name of the method that did.
        table: what was returned.
        shape: as the contract says.
        dtype: as the contract says.
        low: least value.
        high: largest value.

    Raises:
        ConfigError: it is not.
    """
    wanted = f"{choice}: {full_name(type(component))}.{method}() should give {np.dtype(dtype)} of shape {shape}"
    if not isinstance(table, np.ndarray) or table.shape != shape or table.dtype != dtype:
        found = f"{table.dtype} of shape {table.shape}" if isinstance(table, np.ndarray) else type(table).__name__
        raise ConfigError(f"{wanted}, not {found}")
    if not table.size:
        raise ConfigError(f"{wanted}, all {_range(low, high)}; it gives none")
    each = _each_once(table)
    least, most = each.min(), each.max()
    if not (least >= low and most <= high):  # no number at all is neither
        raise ConfigError(f"{wanted}, all {_range(low, high)}; it gives {least} to {most}")
    return table


def _each_once(table: NDArray[Scalar]) -> NDArray[Scalar]:
    """Return an array without repetitions by broadcasting, as of codes that are the same in all periods."""
    return table[tuple(slice(0, 1) if stride == 0 else slice(None) for stride in table.strides)]


def _range(low: float, high: float) -> str:
    """Return a range in words; a bound that is only the largest number of its type is left out."""
    if high not in (LARGEST, LARGEST_CODE):
        return f"from {low} to {high}"
    return "finite" if low == -high else f"at least {low}"
