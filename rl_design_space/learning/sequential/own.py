"""Small functions of components, compiled once in a process and called by their address.

So the kernel need not be compiled again for each of them.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba import cfunc, njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from rl_design_space.design import Counters, DesignPoint, Step
from rl_design_space.design.identity import full_name
from rl_design_space.errors import ConfigError

_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
#: What components write themselves may index wrongly, which must not write anywhere else.
_GUARDED: dict[str, Any] = {**_OPTIONS, "boundscheck": True}
#: What the kernel notes instead of the number of changed rows, see `refuse_broken`.
BROKEN_UPDATE, BROKEN_RULE = -1, -2
#: What update and rule are called with.
_OF_UPDATE, _OF_RULE = ("step", "q", "memory", "parameters"), ("counters", "parameters")
_NUMBER, _REAL = types.int64, types.float64


@intrinsic
def _call_address(typingctx, address, arguments):
    """Call the compiled function at an address with a tuple of int64 and float64; its result is a float64."""

    def codegen(context, builder, signature, values):
        kinds = [context.get_value_type(kind) for kind in signature.args[1].types]
        function = ir.FunctionType(context.get_value_type(types.float64), kinds)
        pointer = builder.inttoptr(values[0], function.as_pointer())
        return builder.call(pointer, cgutils.unpack_tuple(builder, values[1]))

    return types.float64(address, arguments), codegen


#: Typed as anything: type checkers see the arguments of the compiler.
call_address: Any = _call_address


@intrinsic
def _to_pointer(typingctx, address):
    """Return an address as a pointer."""

    def codegen(context, builder, signature, values):
        return builder.inttoptr(values[0], cgutils.voidptr_t)

    return types.voidptr(address), codegen


_pointer: Any = _to_pointer


@cache
def compiled_rule(function: Callable[..., Any], name: str) -> Any:
    """Return the compiled form of a rule of a closed loop, which gives NaN if it raises; see `design.ClosedLoop`.

    Raises:
        ConfigError: it cannot be compiled.
    """
    place = f"exploration: {name}.rule()"
    _check_arguments(function, _OF_RULE, place)
    rule = njit(**_GUARDED)(function)

    def call(trial, level, successes, succeeded, steps, error, parameters, count):
        numbers = carray(_pointer(parameters), (count,), np.float64)
        try:
            return rule(Counters(trial, level, successes, succeeded, steps, error), numbers)
        except Exception:
            return np.nan

    return _compiled(call, types.float64(*[_REAL] * 6, _NUMBER, _NUMBER), place)


@cache
def compiled_update(function: Callable[..., Any], name: str) -> Any:
    """Return the compiled form of a learner's update, which gives NaN if it raises; see `design.OwnLearner`.

    Raises:
        ConfigError: it cannot be compiled.
    """
    place = f"learner: {name}.update()"
    _check_arguments(function, _OF_UPDATE, place)
    update = njit(**_GUARDED)(function)

    def call(
        q, memory, rows, width, n_actions, row, action, next_row, next_action, terminal, reward, alpha, gamma,
        parameters, count,
    ):  # fmt: skip
        values = carray(_pointer(q), (rows, width), np.float64)[:, :n_actions]
        kept = carray(_pointer(memory), (rows, width), np.float64)[:, :n_actions]
        numbers = carray(_pointer(parameters), (count,), np.float64)
        step = Step(row, action, reward, next_row, next_action, terminal != 0, alpha, gamma)
        try:
            return update(step, values, kept, numbers)
        except Exception:
            return np.nan

    signature = types.float64(*[_NUMBER] * 10, *[_REAL] * 3, _NUMBER, _NUMBER)
    return _compiled(call, signature, place)


def _check_arguments(function: Callable[..., Any], expected: Sequence[str], name: str) -> None:
    """Refuse a function that cannot be called with so many arguments; Numba's message would name the caller.

    Raises:
        ConfigError: it takes others.
    """
    taken = inspect.signature(function)
    try:
        taken.bind(*expected)
    except TypeError as error:
        raise ConfigError(f"{name}: takes {taken}; should be a static method of ({', '.join(expected)})") from error


def _compiled(function: Callable[..., Any], signature: Any, name: str) -> Any:
    try:
        return cfunc(signature, **_OPTIONS)(function)
    except Exception as error:
        told = " ".join(str(error).split())
        raise ConfigError(f"{name}: cannot be compiled by Numba: {told}") from error


def refuse_broken(point: DesignPoint, rows: NDArray[np.int32]) -> None:
    """Refuse a result in which a function of a component has given what cannot be used.

    Args:
        point: the design point.
        rows: (periods, 2) of the kernel, negative in a period where that has happened.

    Raises:
        ConfigError: it has.
    """
    broken = np.flatnonzero(rows[:, 1] < 0)
    if not broken.size:
        return
    period, which = int(broken[0]), int(rows[broken[0], 1])
    if which == BROKEN_UPDATE:
        name = f"learner: {full_name(type(point.learner))}.update()"
        what = "gave an error or Q-values that are no finite numbers, or an index out of range"
    else:
        name = f"exploration: {full_name(type(point.exploration))}.rule()"
        what = "should give ε, a number from 0 to 1"
    raise ConfigError(f"{name}: {what}, in period {period}")
