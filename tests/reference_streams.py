"""Random streams, layouts and generators of periods, written from the specification: one word after the other."""

from __future__ import annotations

import numpy as np

from rl_design_space.design import DesignPoint

WORD = 2**64
HALF = 2**32

LAYOUT_STREAM, BEHAVIOUR_STREAM = 0, 1


class Xoshiro:
    """xoshiro256++ on whole numbers."""

    def __init__(self, state: list[int]) -> None:
        self.state = list(state)

    def next_word(self) -> int:
        a, b, c, d = self.state
        word = (_rotated((a + d) % WORD, 23) + a) % WORD
        shifted = b * 2**17 % WORD
        c ^= a
        d ^= b
        b ^= c
        a ^= d
        c ^= shifted
        d = _rotated(d, 45)
        self.state = [a, b, c, d]
        return word


def _rotated(word: int, bits: int) -> int:
    return (word << bits) % WORD | word >> (64 - bits)


def _words(seed: int, period: int, stream: int, count: int) -> list[int]:
    return np.random.SeedSequence(seed, spawn_key=(period, stream)).generate_state(count, np.uint64).tolist()


def layout_of(point: DesignPoint, period: int, number: int = 0) -> list[int]:
    """Start and goals: the first cards of a shuffled deck of cells; of the layout with this number."""
    width, height = point.world.shape
    deck = list(range(width * height))
    dealt = 1 + point.task.goals
    for position, word in enumerate(_words(point.seed, period, _layout_stream(number), dealt)):
        left = len(deck) - position
        drawn = position + word * left // WORD
        deck[position], deck[drawn] = deck[drawn], deck[position]
    return deck[:dealt]


def layout_word(point: DesignPoint, period: int, number: int) -> int:
    """The first random word of a layout."""
    return _words(point.seed, period, _layout_stream(number), 1)[0]


def _layout_stream(number: int) -> int:
    return BEHAVIOUR_STREAM + number if number else LAYOUT_STREAM


def generator_of(point: DesignPoint, period: int) -> Xoshiro:
    return Xoshiro(_words(point.seed, period, BEHAVIOUR_STREAM, 4))
