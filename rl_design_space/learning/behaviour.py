"""Choosing the next action in all lanes: ε-greedy, from one 64-bit random word for each decision.

The upper half of the word decides whether to explore, the lower half selects the action. Words come from
xoshiro256++ (Blackman and Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS 47, 2021).

Both loops have no branches and run over plain columns, so that the compiler turns each into vector instructions that
process several lanes at a time.
"""

from __future__ import annotations

from rl_design_space.learning.compiled import inlined
from rl_design_space.learning.lanes import ACTION, LANES, MAXIMA, S0, S1, S2, S3, THRESHOLD, WORD, index
from rl_design_space.learning.rows import count_of_bits

#: ε is compared with a resolution of 2^-32.
COIN_SIDES = 2**32

_0, _1, _32 = index(0), index(1), index(32)
_LOW = index(0xFFFFFFFF)


@inlined
def _rotated(word, bits):
    return (word << index(bits)) | (word >> index(64 - bits))


@inlined
def draw_one(numbers, lane):
    """Draw one word of xoshiro256++ for a lane."""
    s0, s1, s2, s3 = numbers[S0 + lane], numbers[S1 + lane], numbers[S2 + lane], numbers[S3 + lane]
    numbers[WORD + lane] = _rotated(s0 + s3, 23) + s0
    shifted = s1 << index(17)
    s2 ^= s0
    s3 ^= s1
    s1 ^= s2
    s0 ^= s3
    numbers[S0 + lane], numbers[S1 + lane] = s0, s1
    numbers[S2 + lane], numbers[S3 + lane] = s2 ^ shifted, _rotated(s3, 45)


@inlined
def draw(numbers, running):
    """Draw one word for every running lane."""
    for lane in range(running):
        draw_one(numbers, lane)


@inlined
def choose(numbers, values, running, limits, rules):
    """Choose an action for every running lane, from its word and the Q-values of its current row."""
    n_actions = index(len(limits))
    for lane in range(running):
        word = numbers[WORD + lane]
        lower = word & _LOW
        best = values[lane]
        for action in range(1, len(limits)):
            value = values[index(action * LANES) + lane]
            best = value if value > best else best
        count = _1
        if not rules.first_maximum:
            count = _0
            for action in range(len(limits)):
                count += index(values[index(action * LANES) + lane] >= best)
        # The upper part of the product selects one of `count` maxima; its lower part is uniform for the next draw.
        product = lower * count
        skip = product >> _32
        greedy = seen = _0
        # The last action needs no test: it is chosen if no other one is.
        for action in range(len(limits) - 1):
            seen += index(values[index(action * LANES) + lane] >= best)
            greedy += index(seen <= skip)
        _decide(numbers, lane, word, product, greedy, n_actions, rules)


@inlined
def choose_by_bits(numbers, running, limits, rules):
    """Choose as `choose` does, from the bits of the actions whose Q-values are the maximum."""
    for lane in range(running):
        word, bits = numbers[WORD + lane], numbers[MAXIMA + lane]
        product = (word & _LOW) * (_1 if rules.first_maximum else count_of_bits(bits))
        skip = product >> _32
        greedy = seen = _0
        for action in range(len(limits) - 1):
            seen += (bits >> index(action)) & _1
            greedy += index(seen <= skip)
        _decide(numbers, lane, word, product, greedy, index(len(limits)), rules)


@inlined
def _decide(numbers, lane, word, product, greedy, n_actions, rules):
    """Choose the greedy action or explore."""
    if rules.explore_all:
        other = ((word & _LOW) * n_actions) >> _32
    else:
        other = ((product & _LOW) * (n_actions - _1)) >> _32
        other += index(other >= greedy)
    explores = (word >> _32) < numbers[THRESHOLD + lane]
    numbers[ACTION + lane] = other if explores else greedy
