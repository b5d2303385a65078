"""Choosing an action of one agent, from one random word, and the probabilities of its choices.

`values` holds the Q-values of the agent's row, one for each action; they may be changed. `counts` holds how often each
action was chosen there, for upper bounds only.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.compiled import inlined, uncounted
from rl_design_space.learning.lanes import index
from rl_design_space.learning.sequential.elementary import exponential, logarithm
from rl_design_space.learning.sequential.method import SOFTMAX, UPPER_BOUND

_0, _1, _11, _32 = index(0), index(1), index(11), index(32)
_LOW = index(0xFFFFFFFF)
_ULP = 2.0**-53


@inlined
def greatest(values, n_actions):
    """Return the maximum of the values."""
    best = values[0]
    for action in range(1, n_actions):
        best = values[action] if values[action] > best else best
    return best


@inlined
def pick_greatest(values, n_actions, first_maximum, lower):
    """Return one of the maxima, and what is left of the random number for the next draw."""
    best = greatest(values, n_actions)
    count = _1
    if not first_maximum:
        count = _0
        for action in range(n_actions):
            count += index(values[action] >= best)
    product = lower * count
    skip = product >> _32
    greedy = seen = _0
    for action in range(n_actions - 1):
        seen += index(values[action] >= best)
        greedy += index(seen <= skip)
    return greedy, product & _LOW


@inlined
def choose_action(kind, level, threshold, values, counts, row, n_actions, rules, word, scratch):
    """Return the action that a word selects, and whether it is exploratory.

    ε-greedy choices are those of `behaviour.choose`. The others are exploratory where they are not greedy.

    Args:
        kind: of behaviour, see `Behaviour`.
        level: ε, temperature, or weight of the bonus.
        threshold: ε · 2^32.
        values: see above.
        counts: see above, of all rows.
        row: offset of the row.
        n_actions: number of actions.
        rules: see `kernel.Rules`.
        word: the random word.
        scratch: (n_actions,) float64, overwritten.
    """
    if kind == SOFTMAX:
        action = _softmax(values, level, n_actions, word, scratch)
        return action, values[action] < greatest(values, n_actions)
    if kind == UPPER_BOUND:
        _add_bonus(values, level, counts, row, n_actions, scratch)
        action, _ = pick_greatest(scratch, n_actions, rules.first_maximum, word & _LOW)
        return action, values[action] < greatest(values, n_actions)
    lower = word & _LOW
    greedy, rest = pick_greatest(values, n_actions, rules.first_maximum, lower)
    if rules.explore_all:
        other = (lower * index(n_actions)) >> _32
    else:
        other = (rest * index(n_actions - 1)) >> _32
        other += index(other >= greedy)
    explores = (word >> _32) < threshold
    return (other if explores else greedy), explores


@uncounted
def _weigh(values, temperature, n_actions, weights):
    """Enter weights e^((value - best)/temperature); return their sum."""
    best = greatest(values, n_actions)
    total = 0.0
    for action in range(n_actions):
        weights[action] = exponential((values[action] - best) / temperature)
        total += weights[action]
    return total


@uncounted
def _softmax(values, temperature, n_actions, word, weights):
    """Return an action with a probability in proportion to its weight."""
    drawn = (word >> _11) * _ULP * _weigh(values, temperature, n_actions, weights)
    below = 0.0
    for action in range(n_actions - 1):
        below += weights[action]
        if drawn < below:
            return index(action)
    return index(n_actions - 1)


@uncounted
def _add_bonus(values, weight, counts, row, n_actions, bounds):
    """Enter value + weight · √(ln t / N) of each action; one that was never chosen comes first."""
    total = _0
    for action in range(n_actions):
        total += counts[row + index(action)]
    logarithm_of_total = logarithm(total) if total else 0.0
    for action in range(n_actions):
        count = counts[row + index(action)]
        bounds[action] = values[action] + weight * np.sqrt(logarithm_of_total / count) if count else np.inf


@uncounted
def expected(kind, level, values, counts, row, n_actions, rules, scratch, probabilities):
    """Return the mean value under the behaviour; enter its probabilities.

    Args:
        kind: see `choose_action`, as the following.
        level: …
        values: …
        counts: …
        row: …
        n_actions: …
        rules: …
        scratch: …
        probabilities: (n_actions,) float64, output.
    """
    if kind == SOFTMAX:
        total = _weigh(values, level, n_actions, probabilities)
        for action in range(n_actions):
            probabilities[action] /= total
    else:
        epsilon = level
        for action in range(n_actions):
            scratch[action] = values[action]
        if kind == UPPER_BOUND:
            epsilon = 0.0
            _add_bonus(values, level, counts, row, n_actions, scratch)
        best = greatest(scratch, n_actions)
        maxima = 0
        for action in range(n_actions):
            maxima += scratch[action] >= best
        maxima = 1 if rules.first_maximum else maxima
        seen = 0
        for action in range(n_actions):
            is_greedy = scratch[action] >= best and seen < maxima
            seen += is_greedy
            share = 1.0 / maxima if is_greedy else 0.0
            others = 1.0 / n_actions if rules.explore_all else (1.0 - share) / (n_actions - 1)
            probabilities[action] = (1.0 - epsilon) * share + epsilon * others
    mean = 0.0
    for action in range(n_actions):
        mean += probabilities[action] * values[action]
    return mean
