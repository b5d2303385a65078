"""Rows of the Q-matrix as vectors, and sets of actions and of lanes as bits of a number.

A row of 8 or 16 values is one or two vectors. The compiler keeps the order in which floating-point numbers are
compared, so it would load and compare them one by one; here they are compared in halves, which gives the same maximum.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from rl_design_space.learning.lanes import index

_PLACE = ir.IntType(32)


def _compiled_form_of(plain: Callable[..., Any]) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator of instructions to be compiled: the plain function instead if compiling is switched off."""
    compiled = not config.DISABLE_JIT  # type: ignore[attr-defined]
    return lambda instructions: intrinsic(instructions) if compiled else plain


def _loaded(context, builder, signature, values):
    """Return a row as one vector, and its size; `values` begins with Q-matrix and row, limits are the last."""
    array = context.make_array(signature.args[0])(context, builder, values[0])
    count = signature.args[-1].count
    pointer = builder.gep(array.data, [values[1]])
    row = builder.load(builder.bitcast(pointer, ir.VectorType(ir.DoubleType(), count).as_pointer()))
    row.align = 8
    return row, count


def _shuffled(builder, vector, places):
    """Return the elements of a vector at some places."""
    kind = ir.VectorType(_PLACE, len(places))
    return builder.shuffle_vector(vector, ir.Constant(vector.type, ir.Undefined), ir.Constant(kind, places))


def _greater(builder, one, other):
    return builder.select(builder.fcmp_ordered(">", one, other), one, other)


@_compiled_form_of(lambda q, row, limits: max(q[row : row + index(len(limits))]))
def best_of(typingctx, q, row, limits):
    """Return the maximum of a row, which has a value for each of the limits."""

    def codegen(context, builder, signature, values):
        best, count = _loaded(context, builder, signature, values)
        while count % 2 == 0:
            count //= 2
            halves = (_shuffled(builder, best, list(range(first, first + count))) for first in (0, count))
            best = _greater(builder, *halves)
        elements = [builder.extract_element(best, _PLACE(place)) for place in range(count)]
        best = elements[0]
        for element in elements[1:]:
            best = _greater(builder, best, element)
        return best

    return types.float64(q, row, limits), codegen


@_compiled_form_of(
    lambda q, row, best, limits: index(sum(1 << at for at in range(len(limits)) if q[row + index(at)] >= best))
)
def bits_of_best(typingctx, q, row, best, limits):
    """Return a number whose bit a is set if action a has at least the value `best` in a row."""

    def codegen(context, builder, signature, values):
        row_values, count = _loaded(context, builder, signature, values)
        bests = builder.insert_element(ir.Constant(row_values.type, ir.Undefined), values[2], _PLACE(0))
        reached = builder.fcmp_ordered(">=", row_values, _shuffled(builder, bests, [0] * count))
        return builder.zext(builder.bitcast(reached, ir.IntType(count)), ir.IntType(64))

    return types.uint64(q, row, best, limits), codegen


@_compiled_form_of(lambda bits: index(int(bits).bit_count()))
def count_of_bits(typingctx, bits):
    """Return how many bits are set."""
    return types.uint64(types.uint64), lambda _, builder, signature, values: builder.ctpop(values[0])


@_compiled_form_of(lambda bits: index((int(bits) & -int(bits)).bit_length() - 1))
def lowest_bit(typingctx, bits):
    """Return the place of the lowest bit that is set; there is one."""
    return types.uint64(types.uint64), lambda _, builder, signature, values: builder.cttz(values[0], ir.IntType(1)(1))


@_compiled_form_of(lambda bits: index(int(bits).bit_length() - 1))
def highest_bit(typingctx, bits):
    """Return the place of the highest bit that is set; there is one."""

    def codegen(context, builder, signature, values):
        return builder.sub(ir.IntType(64)(63), builder.ctlz(values[0], ir.IntType(1)(1)))

    return types.uint64(types.uint64), codegen
