"""A slow, plain learner, written from the paper and the specification, for the compiled one to agree with.

It shares no code with the package: it walks on a world's transition table, looks its states up by observation
code and keeps the Q-matrix in a dictionary. Floating-point operations come in the specified order, so results are
compared bit for bit. Expressions that look clumsy (0.0 + 1.0·r) are that order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rl_design_space.design import DesignPoint, MultiStepActions, PotentialReward, StochasticWorld, TransitionReward
from tests.reference_streams import HALF, Xoshiro, generator_of, layout_of


@dataclass
class Period:
    """What one period yields; `q` holds one value an action for every observation code."""

    steps: list[int]
    success: list[bool]
    q: dict[int, list[float]]


@dataclass(frozen=True)
class Control:
    """What an action does at an observation: its step, 4 to wait; whether it stops on arriving; what it perceives."""

    step: int
    stops: bool
    mark: int


@dataclass(frozen=True)
class Action:
    """An action of at most `limit` steps; `at` holds its control for every observation code."""

    limit: int
    at: dict[int, Control]


def actions_of(point: DesignPoint, goals: list[int]) -> list[Action]:
    """The actions in a layout; equal observations have equal controls, which is asserted."""
    codes = point.representation.observation(point.world, np.array(goals))
    states = [(s, cell) for s, goal in enumerate(goals) for cell in range(codes.shape[1]) if cell != goal]
    if isinstance(point.msa, MultiStepActions):
        limits = [length for length in (1, *point.msa.lengths) for _ in range(4)]
        steps = [dict.fromkeys(states, number % 4) for number in range(len(limits))]
        stops = [dict.fromkeys(states, False)] * len(limits)
        marks = _marks(point, goals, codes, states)
    else:
        found = point.msa.behaviour(point.world, point.representation, np.array(goals), codes)
        limits = point.msa.limits().tolist()
        steps = [{state: int(of_action[state]) for state in states} for of_action in found.steps]
        stops = [{state: bool(of_action[state]) for state in states} for of_action in found.stops]
        marks = {state: 0 if found.marks is None else int(found.marks[state]) for state in states}
    actions = [Action(limit, {}) for limit in limits]
    for number, action in enumerate(actions):
        for state in states:
            control = Control(steps[number][state], stops[number][state], marks[state])
            assert action.at.setdefault(int(codes[state]), control) == control
    return actions


def _marks(point: DesignPoint, goals: list[int], codes: np.ndarray, states: list[tuple[int, int]]) -> dict:
    """What the stopping rule of multi-step actions looks at."""
    if point.msa.until == "observation_changes":
        return {state: int(codes[state]) for state in states}
    if point.msa.until == "due_goal_observation_changes":
        of_one = [point.representation.observation(point.world, np.array([goal]))[0] for goal in goals]
        return {(s, cell): int(of_one[s][cell]) for s, cell in states}
    return dict.fromkeys(states, 0)


def learn_period(point: DesignPoint, layout: list[int], generator: Xoshiro) -> Period:
    """All trials of a period, from a fresh Q-matrix."""
    actions = actions_of(point, layout[1:])
    codes = point.representation.observation(point.world, np.array(layout[1:])).tolist()
    q = {code: [point.learner.initial_q] * len(actions) for of_counter in codes for code in of_counter}
    return play_trials(point, layout, generator, codes, actions, q)


def play_trials(
    point: DesignPoint,
    layout: list[int],
    generator: Xoshiro,
    codes: list[list],
    actions: list[Action],
    q: dict,
    errors: dict | None = None,
) -> Period:
    """All trials of a period, or of one of its stages, with a Q-matrix that is given.

    How the values of executed actions change goes to `errors`, by success counter, cell and action.
    """
    errors = {} if errors is None else errors
    result = Period([], [], q)
    for epsilon in point.exploration.schedule(point.task.trials).tolist():
        moves, solved = _play_trial(point, layout, codes, actions, q, epsilon, generator, errors)
        result.steps.append(moves)
        result.success.append(solved)
    return result


def learn(point: DesignPoint) -> list[Period]:
    """Every period of a point."""
    periods = range(point.task.periods)
    return [learn_period(point, layout_of(point, period), generator_of(point, period)) for period in periods]


def _play_trial(point, layout, codes, actions, q, epsilon, generator, errors):
    cell, *goals = layout
    cap = point.task.max_steps
    step_of, reward_of = steps_of(point), rewards_of(point, goals)
    reached = moves = 0
    while reached < len(goals) and moves < cap:
        state = codes[reached][cell]
        number = choose(q[state], epsilon, generator.next_word(), point.learner)
        action = actions[number]
        control = action.at[state]
        states, made, rewards = [state], [], []
        began, old = (reached, cell, number), q[state][number]
        stopped = False
        while True:
            before, (cell, outcome) = cell, step_of(control.step, cell, generator)
            moves += 1
            made.append(control.step)
            due = cell == goals[reached]
            rewards.append(reward_of(reached, control.step, before, outcome, cell))
            reached += due
            if reached == len(goals):
                states.append(None)  # terminal: there is nothing to observe any more
                break
            states.append(codes[reached][cell])
            control = action.at[states[-1]]
            stopped = due and point.msa.sub_goal == "stop"
            if moves == cap or stopped or ends(action, len(made), state, states[-1]):
                break
        gain = gain_of(point, action.limit, rewards)
        update(point, q, state, number, gain, len(rewards), states[-1])
        errors.setdefault(began, []).append(q[state][number] - old)
        propagate(point, q, actions, number, states, made, rewards, stopped)
    return moves, reached == len(goals)


def ends(action, made, began, state):
    """Whether an action ends by its own rule after so many steps."""
    control = action.at[state]
    return made == action.limit or control.stops or control.mark != action.at[began].mark


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


def steps_of(point):
    """What makes a step: it returns the cell that the step leads to, and which of its outcomes that is."""
    next_cell = point.world.next_cell().tolist()
    if not isinstance(point.world, StochasticWorld):
        return lambda step, cell, generator: (next_cell[step][cell] if step < 4 else cell, 0)
    cells, probabilities = point.world.outcomes()
    if set(probabilities.ravel().tolist()) <= {0, 1}:
        which = probabilities.argmax(axis=2)
        return lambda step, cell, generator: (
            (int(cells[step, cell, which[step, cell]]), int(which[step, cell])) if step < 4 else (cell, 0)
        )

    def step_of(step, cell, generator):
        coin = generator.next_word() // HALF
        if step == 4:
            return cell, 0
        outcome, most = 0, 0.0
        for probability in probabilities[step, cell, :-1].tolist():
            most += probability
            outcome += coin >= round(most * HALF)
        return int(cells[step, cell, outcome]), outcome

    return step_of


def rewards_of(point, goals):
    """What a step from a state earns, by its outcome and the cell that it leads to."""
    world, reward, gamma = point.world, point.reward, point.learner.gamma
    more = reward.by_transition(world, np.array(goals)) if isinstance(reward, TransitionReward) else None
    height = reward.potential(world, np.array(goals)) if isinstance(reward, PotentialReward) else None

    def reward_of(reached, step, before, outcome, cell):
        found = _reward(point, cell, goals, reached)
        if more is not None and step < 4:
            of_outcomes = more[reached, step, before]
            found += float(of_outcomes if more.ndim == 3 else of_outcomes[outcome])
        if height is not None:
            then = reached + (cell == goals[reached])
            found += gamma * (float(height[then, cell]) if then < len(goals) else 0.0) - float(height[reached, before])
        return found

    return reward_of


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


def propagate(point, q, actions, number, states, made, rewards, stopped):
    """Update other actions from the states that the executed one has passed."""
    if point.msa.propagation == "consistent":
        _propagate_to_consistent(point, q, actions, number, states, made, rewards, stopped)
    else:
        _propagate_to_shorter(point, q, actions[number].limit, states, made, rewards)


def _propagate_to_shorter(point, q, limit, states, made, rewards):
    """Update the shorter actions that the executed one contains, in the order of time."""
    msa = point.msa
    executed = len(rewards)
    if isinstance(msa, MultiStepActions):
        lengths = (1, *msa.lengths)
        learning = {"none": (), "primitives": (1,), "all_shorter": lengths}[msa.propagation]
    else:
        lengths = (1,)
        learning = lengths if msa.primitives and msa.propagation == "primitives" else ()
    for shorter in learning:
        if shorter < limit:
            for first in range(executed - shorter + 1):
                if made[first] == 4:
                    continue
                contained = made[first] + 4 * lengths.index(shorter)
                last = first + shorter
                gain = _return(rewards[first:last], point.learner.gamma)
                update(point, q, states[first], contained, gain, shorter, states[last])


def _propagate_to_consistent(point, q, actions, number, states, made, rewards, stopped):
    """Update every action that would have made the same steps from a state on and would have ended by itself."""
    for other, action in enumerate(actions):
        for first, began in enumerate(states[:-1]):
            if (other, first) == (number, 0):
                continue
            ended = False
            last = first
            while not ended and last < len(made) and action.at[states[last]].step == made[last]:
                last += 1
                goal = states[last] is None
                ended = goal or ends(action, last - first, began, states[last]) or (stopped and last == len(made))
            if ended:
                gain = _return(rewards[first:last], point.learner.gamma)
                update(point, q, began, other, gain, last - first, states[last])


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
