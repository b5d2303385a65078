"""Branch and bound for the policy with the fewest steps on a graph, where states that look the same share an action.

Actions are assigned to observations in the order in which the path meets them, and a branch is given up if even free
choice in all observations without an action could not save it. States are numbered, `following` and `steps` are those
of `memoryless.Decisions`, and `row` is the observation of each state.
"""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.compiled import compiled, compiled_and_kept


@compiled
def _fewest(following, steps, row, policy, origin, target, limit, unit, distance, queue, queued):
    """Return the fewest steps between two states where observations with an action allow that one alone; -1 if none.

    States are looked at again when a shorter way to them is found, which is never the case if all steps are one.
    """
    n_actions, states = following.shape
    distance[:] = -1
    distance[origin] = 0
    queue[0] = origin
    head, waiting = 0, 1
    while waiting:
        state = queue[head]
        head = (head + 1) % states
        waiting -= 1
        queued[state] = False
        if state == target:
            if unit:
                for place in range(waiting):
                    queued[queue[(head + place) % states]] = False
                break
            continue
        only = policy[row[state]]
        for action in range(n_actions):
            if only >= 0 and action != only:
                continue
            after = following[action, state]
            there = distance[state] + steps[action, state]
            if there <= limit and (distance[after] < 0 or there < distance[after]):
                distance[after] = there
                if not queued[after]:
                    queue[(head + waiting) % states] = after
                    queued[after] = True
                    waiting += 1
    return distance[target]


@compiled
def _followed(following, steps, row, policy, state, target, made):
    """Follow a policy up to an observation without an action.

    Returns:
        The state there, the steps made, and whether the policy goes round in a circle instead.
    """
    for _ in range(following.shape[1]):
        action = policy[row[state]]
        if state == target or action < 0:
            return state, made, False
        made += steps[action, state]
        state = following[action, state]
    return state, made, True


@compiled_and_kept
def search(following, steps, row, origin, target, cap, nodes, unit):
    """Search the policy with the fewest steps between two states.

    Returns:
        The steps of the best one found, -1 if none, and the fewest that any could need: one more than the cap if it is
        proven that none reaches the target.
    """
    n_actions, states = following.shape
    n_rows = row.max() + 1
    policy = np.full(n_rows, -1, dtype=np.int64)
    distance, queue, queued = (
        np.empty(states, dtype=np.int64),
        np.empty(states, dtype=np.int64),
        np.zeros(states, dtype=np.bool_),
    )
    least = _fewest(following, steps, row, policy, origin, target, cap, unit, distance, queue, queued)
    if least < 0:
        return -1, cap + 1
    # By depth of the search: the observation, the state where it is met first, the steps up to there, the actions that
    # are worth a try, the steps that each needs at least, their number, and how many were tried.
    rows, places, before = (
        np.empty(n_rows, dtype=np.int64),
        np.empty(n_rows, dtype=np.int64),
        np.empty(n_rows, dtype=np.int64),
    )
    options, needs = np.empty((n_rows, n_actions), dtype=np.int64), np.empty((n_rows, n_actions), dtype=np.int64)
    number, tried = np.empty(n_rows, dtype=np.int64), np.empty(n_rows, dtype=np.int64)
    best, depth, used = -1, 0, 0
    state, made = origin, 0
    while True:
        state, made, goes_round = _followed(following, steps, row, policy, state, target, made)
        if state == target:
            if made <= cap and (best < 0 or made < best):
                best = made
                if best == least:
                    return best, least
        elif not goes_round:
            used += 1
            if used > nodes:
                return best, least
            limit = cap if best < 0 else best - 1
            rows[depth], places[depth], before[depth] = row[state], state, made
            count = 0
            for action in range(n_actions):
                policy[row[state]] = action
                need = made + steps[action, state]
                after = following[action, state]
                more = _fewest(
                    following, steps, row, policy, after, target, limit - need, unit, distance, queue, queued
                )
                if need <= limit and more >= 0:
                    place = count
                    while place > 0 and needs[depth, place - 1] > need + more:
                        needs[depth, place], options[depth, place] = needs[depth, place - 1], options[depth, place - 1]
                        place -= 1
                    needs[depth, place], options[depth, place] = need + more, action
                    count += 1
            policy[row[state]] = -1
            number[depth], tried[depth] = count, 0
            depth += 1
        # Go back to the last observation with an untried action that could be better.
        while depth:
            top = depth - 1
            if tried[top] < number[top] and (best < 0 or needs[top, tried[top]] < best):
                break
            policy[rows[top]] = -1
            depth -= 1
        if depth == 0:
            return best, best if best >= 0 else cap + 1
        top = depth - 1
        policy[rows[top]] = options[top, tried[top]]
        tried[top] += 1
        state, made = places[top], before[top]
