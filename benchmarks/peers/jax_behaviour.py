"""What both JAX peers share: random words and the ε-greedy choice, written out for four actions.

Faster than the general forms: `jax.random` takes longer than all the rest of a step together, and `argmax` over
four values longer than comparing them one by one.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray

#: (2,) uint32 for one period.
Generator = tuple[jax.Array, jax.Array]


def generators(seed: int, periods: int) -> NDArray[np.uint32]:
    """(periods, 2) initial states, none of them zero."""
    return np.random.default_rng(seed).integers(1, 2**32, (periods, 2), dtype=np.uint32)


def next_word(state: Generator) -> tuple[jax.Array, Generator]:
    """One word of xoroshiro64* (Blackman and Vigna, 2021) and the state after it."""
    first, second = state
    word = first * jnp.uint32(0x9E3779BB)
    second = second ^ first
    first = ((first << 26) | (first >> 6)) ^ second ^ (second << 9)
    return word, (first, (second << 13) | (second >> 19))


def choose(values: jax.Array, epsilon: jax.Array, coin: jax.Array, pick: jax.Array) -> jax.Array:
    """An action by two words: `coin` whether to explore, `pick` which action. values: (4,)."""
    q = [values[action] for action in range(4)]
    best = jnp.maximum(jnp.maximum(q[0], q[1]), jnp.maximum(q[2], q[3]))
    # How many of the first actions are best; the upper half of `pick` draws one of all that are.
    tied = [(value == best).astype(jnp.uint32) for value in q]
    up_to_1, up_to_2, up_to_3 = tied[0] + tied[1], tied[0] + tied[1] + tied[2], sum(tied)
    skip = ((pick >> 16) * up_to_3) >> 16
    greedy = (tied[0] <= skip).astype(jnp.uint32) + (up_to_1 <= skip) + (up_to_2 <= skip)
    other = ((pick & 0xFFFF) * 3) >> 16
    other = other + (other >= greedy)
    explores = (coin >> 8).astype(jnp.float32) * jnp.float32(2**-24) < epsilon
    return jnp.where(explores, other, greedy).astype(jnp.int32)
