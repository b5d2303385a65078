"""A slow, plain learner, written from the paper and the specification, for the compiled one to agree with.

It shares no code with the package: it walks on a world's transition table, looks its states up by observation
code and keeps the Q-matrix in a dictionary. Floating-point operations come in the specified order, so results are
compared bit for bit. Expressions that look clumsy (0.0 + 1.0·r) are that order.
"""

from __future__ import annotations

from dataclasses import dataclass

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


@dataclass
class Period:
    """What one period yields; `q` holds one value an action for every observation code."""

    steps: list[int]
    success: list[bool]
    q: dict[int, list[float]]


def learn_period(point: DesignPoint, layout: list[int], generator: Xoshiro) -> Period:
    """All trials of a period, from a fresh Q-matrix."""
    codes = point.representation.observation(point.world, np.array(layout[1:])).tolist()
    n_actions = 4 * (1 + len(point.msa.lengths))
    q = {code: [point.learner.initial_q] * n_actions for of_counter in codes for code in of_counter}
    return play_trials(point, layout, generator, codes, q)


def play_trials(point: DesignPoint, layout: list[int], generator: Xoshiro, codes: list[list], q: dict) -> Period:
    """All trials of a period, or of one of its stages, with a Q-matrix that is given."""
    actions = [(move, length) for length in [1, *point.msa.lengths] for move in range(4)]
    result = Period([], [], q)
    for epsilon in point.exploration.schedule(point.task.trials).tolist():
        moves, solved = _play_trial(point, layout, codes, actions, q, epsilon, generator)
        result.steps.append(moves)
        result.success.append(solved)
    return result


def learn(point: DesignPoint) -> list[Period]:
    """Every period of a point."""
    periods = range(point.task.periods)
    return [learn_period(point, layout_of(point, period), generator_of(point, period)) for period in periods]


def _play_trial(point, layout, codes, actions, q, epsilon, generator):
    cell, *goals = layout
    cap = point.task.max_steps
    next_cell = point.world.next_cell().tolist()
    reached = moves = 0
    while reached < len(goals) and moves < cap:
        values = q[codes[reached][cell]]
        action = choose(values, epsilon, generator.next_word(), point.learner)
        move, length = actions[action]
        states, rewards = [codes[reached][cell]], []
        while len(rewards) < length:
            cell = next_cell[move][cell]
            moves += 1
            due = cell == goals[reached]
            rewards.append(_reward(point, cell, goals, reached))
            reached += due
            if reached == len(goals):
                states.append(None)  # terminal: there is nothing to observe any more
                break
            states.append(codes[reached][cell])
            if moves == cap or (due and point.msa.sub_goal == "stop"):
                break
        gain = gain_of(point, length, rewards)
        update(point, q, states[0], action, gain, len(rewards), states[-1])
        propagate(point, q, actions[action], states, rewards)
    return moves, reached == len(goals)


def choose(values, epsilon, word, learner):
    """ε-greedy with a single word: its upper half decides whether to explore, its lower half what to do."""
    upper, lower = divmod(word, HALF)
    explores = upper < round(epsilon * HALF)
    if explores and learner.explore == "all":
        return lower * len(values) // HALF
    maxima = [action for action, value in enumerate(values) if value == max(values)]
    if learner.ties == "first":
        maxima = maxima[:1]
    which, rest = divmod(lower * len(maxima), HALF)
    greedy = maxima[which]
    if not explores:
        return greedy
    others = [action for action in range(len(values)) if action != greedy]
    return others[rest * len(others) // HALF]


def _reward(point, cell, goals, reached):
    step, sub_goal, final_goal = point.reward.table().tolist()
    if cell == goals[reached]:
        return final_goal if reached == len(goals) - 1 else sub_goal
    if cell in goals and point.learner.out_of_order == "zero":
        return 0.0
    return step


def gain_of(point, length, rewards):
    """What an executed action of this length is worth."""
    if length > 1 and point.msa.reward == "printed":
        rewards = [rewards[0]] * (len(rewards) + 1)
    return _return(rewards, point.learner.gamma)


def propagate(point, q, action, states, rewards):
    """Update the shorter actions that the executed one contains, in the order of time."""
    msa = point.msa
    move, length = action
    gamma = point.learner.gamma
    executed = len(rewards)
    lengths = (1, *msa.lengths)
    learning = {"none": (), "primitives": (1,), "all_shorter": lengths}[msa.propagation]
    for shorter in learning:
        if shorter < length:
            contained = move + 4 * lengths.index(shorter)
            for first in range(executed - shorter + 1):
                last = first + shorter
                update(point, q, states[first], contained, _return(rewards[first:last], gamma), shorter, states[last])


def update(point, q, state, action, gain, executed, following):
    learner = point.learner
    best_next = 0.0 if following is None else max(q[following])
    discount = 1.0
    for _ in range(executed):
        discount *= learner.gamma
    old = q[state][action]
    if learner.update == "printed":
        q[state][action] = old + learner.alpha * (gain + discount * (best_next - old))
    else:
        q[state][action] = old + learner.alpha * (gain + discount * best_next - old)


def _return(rewards, gamma):
    gain, discount = 0.0, 1.0
    for reward in rewards:
        gain += discount * reward
        discount *= gamma
    return gain
