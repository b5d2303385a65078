"""Small functions of components, compiled once in a process and called by their address.

So the kernel need not be compiled again for each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from llvmlite import ir
from numba import cfunc, njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from rl_design_space.design import Counters, Step
from rl_design_space.errors import ConfigError

_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy"}
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
    """Return the compiled form of a rule of a closed loop; see `design.ClosedLoop`.

    Raises:
        ConfigError: it cannot be compiled.
    """
    rule = njit(**_OPTIONS)(function)

    def call(trial, level, successes, succeeded, steps, error, parameters, count):
        numbers = carray(_pointer(parameters), (count,), np.float64)
        return rule(Counters(trial, level, successes, succeeded, steps, error), numbers)

    return _compiled(call, types.float64(*[_REAL] * 6, _NUMBER, _NUMBER), f"exploration: {name}.rule()")


@cache
def compiled_update(function: Callable[..., Any], name: str) -> Any:
    """Return the compiled form of a learner's update; see `design.OwnLearner`.

    Raises:
        ConfigError: it cannot be compiled.
    """
    update = njit(**_OPTIONS)(function)

    def call(
        q, memory, rows, width, n_actions, row, action, next_row, next_action, terminal, reward, alpha, gamma,
        parameters, count,
    ):  # fmt: skip
        values = carray(_pointer(q), (rows, width), np.float64)[:, :n_actions]
        kept = carray(_pointer(memory), (rows, width), np.float64)[:, :n_actions]
        numbers = carray(_pointer(parameters), (count,), np.float64)
        step = Step(row, action, reward, next_row, next_action, terminal != 0, alpha, gamma)
        return update(step, values, kept, numbers)

    signature = types.float64(*[_NUMBER] * 10, *[_REAL] * 3, _NUMBER, _NUMBER)
    return _compiled(call, signature, f"learner: {name}.update()")


def _compiled(function: Callable[..., Any], signature: Any, name: str) -> Any:
    try:
        return cfunc(signature, **_OPTIONS)(function)
    except Exception as error:
        told = " ".join(str(error).split())
        raise ConfigError(f"{name}: cannot be compiled by Numba: {told}") from error
