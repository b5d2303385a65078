"""The sequential kernel: all trials of one period after the other, one step of one agent at a time."""

from __future__ import annotations

import numpy as np

from rl_design_space.learning.behaviour import COIN_SIDES, draw
from rl_design_space.learning.chance import earned, land, pay_of
from rl_design_space.learning.compiled import compiled, inlined, uncounted
from rl_design_space.learning.lanes import FINAL_GOAL, KIND, SUB_GOAL, WORD, index, row_width
from rl_design_space.learning.periods import begin_period, end_period
from rl_design_space.learning.sequential.choosing import choose_action, greatest
from rl_design_space.learning.sequential.closed_loop import level_after
from rl_design_space.learning.sequential.learners import (
    after_choice,
    begin_learning,
    begin_trial_of,
    end_learning,
    learn_from_step,
    show,
)
from rl_design_space.learning.sequential.memory import new_memory
from rl_design_space.learning.sequential.method import EPSILON_GREEDY, OWN, UPPER_BOUND
from rl_design_space.learning.sequential.own import BROKEN_RULE, BROKEN_UPDATE

_0, _1, _2, _3 = (index(number) for number in range(4))


@compiled
def learn_in_sequence(
    next_of, limits, rules, reward_of, observation, first, layout, generator, lanes, steps, success, rows, table,
    chance, earnings, method,
):  # fmt: skip
    """Learn periods one after the other, all in the first lane; the arguments are those of `kernel.learn`.

    Args:
        next_of: the cell that each step leads to, see `action_tables.step_table`.
        limits: …
        rules: …
        reward_of: rewards by kind of cell, see `lanes`.
        observation: …
        first: …
        layout: …
        generator: …
        lanes: …
        steps: …
        success: …
        rows: …
        table: …
        chance: …
        earnings: …
        method: see `Method`.
    """
    taken, n_goals, cells = observation.shape
    n_actions, width = len(limits), row_width(len(limits))
    learner, behaviour, step_sizes = method.learner, method.behaviour, method.step_sizes
    trail, q_after = method.notes.trail, method.notes.q_after
    q, entries = lanes.q[0], lanes.entries[0]
    pay = pay_of(lanes, earnings, chance, n_goals * cells)
    memory = new_memory(lanes.numbers, q, method, n_actions)
    for begun in range(taken):
        period = first + begun
        codes = observation[begun].ravel()
        layout_of, state = layout[period], generator[period]
        begin_period(lanes, 0, period, codes, layout_of, state, limits, rules.initial_q, rows, begun, table, earnings)
        used = rows[period, 0] * width
        begin_learning(learner, memory, used)
        start, level = index(layout[period, 0]), behaviour.levels[0]
        # Literals have types of their own, for which functions would be compiled, too.
        successes, at = np.int64(0), np.int64(0)
        total_error = 0.0
        broken = 0
        for trial in range(steps.shape[1]):
            if trial > 0 and behaviour.rule != 0:
                succeeded, made = success[period, trial - 1], steps[period, trial - 1]
                level = level_after(behaviour, trial, level, successes, succeeded, made, total_error / made)
                if not 0.0 <= level <= 1.0:
                    broken, level = BROKEN_RULE, 0.0
            elif behaviour.rule == 0:
                level = behaviour.levels[trial]
            made, succeeded, total_error = _play_trial(
                learner, memory, behaviour, level, rules, limits, step_sizes.alphas[trial], step_sizes.power,
                next_of, entries, reward_of, start, index(cells), chance, pay, trail, at,
            )  # fmt: skip
            if learner.kind == OWN and not np.isfinite(total_error):
                broken = BROKEN_UPDATE
            steps[period, trial], success[period, trial] = made, succeeded
            successes += succeeded
            at += made + 1
            if len(q_after):
                _note_q(learner, memory, q_after[trial], n_actions, width)
        end_learning(learner, memory, used)
        end_period(lanes, _0, limits, rules.initial_q, rows, period)
        if broken == 0 and learner.kind == OWN and not np.all(np.isfinite(q[:used])):
            broken = BROKEN_UPDATE
        if broken < 0:
            rows[period, 1] = broken


@inlined
def _move(next_of, entries, random, cell, stage, action, chance):
    """Make one step; return the cell and the entry that it leads to, and the number of its outcome."""
    at, outcome = (cell << _2) + (action & _3), _0
    if chance is None:
        cell = index(next_of[at])
    else:
        cell, outcome = land(random, _0, at, chance)
    return cell, index(entries[stage + cell]), outcome


@uncounted
def _play_trial(
    learner, memory, behaviour, level, rules, limits, alpha, power, next_of, entries, reward_of, start, cells, chance,
    pay, trail, at,
):  # fmt: skip
    """Play one trial; return its steps, whether it was a success, and the sum of the sizes of its errors.

    In each turn of the loop the agent learns from its last step, chooses, and moves, each if it can. A learner that
    chooses first takes two turns a step. So the code of each part is compiled once.
    """
    n_actions = len(limits)
    threshold = _0
    if behaviour.kind == EPSILON_GREEDY:
        threshold = index(np.rint(level * COIN_SIDES))
        level = threshold / COIN_SIDES
    # Literals have types of their own, for which functions would be compiled, too.
    cell, stage, time, counter = start, _0, np.int64(0), 0
    row = action = next_action = kind = _0
    reward = 0.0
    next_row = index(entries[cell]) & ~KIND
    if len(trail.cells):
        trail.cells[at], trail.counters[at] = cell, counter
    begin_trial_of(learner, memory)
    total_error = 0.0
    has_moved = has_chosen = explores = False
    ended = terminal = np.bool_(False)
    while True:
        if has_moved and (has_chosen or terminal or not learner.chooses_first):
            error = learn_from_step(
                learner, memory, behaviour.kind, level, rules, n_actions, alpha, power, time, row, action,
                reward, next_row, next_action, terminal, ended,
            )  # fmt: skip
            total_error += abs(error)
            time += 1
            if ended:
                return time, terminal, total_error
            has_moved = False
        if not has_chosen:
            show(learner, memory, next_row, n_actions)
            draw(memory.random, 1)
            next_action, explores = choose_action(
                behaviour.kind, level, threshold, memory.values, memory.chosen, next_row, n_actions, rules,
                memory.random[WORD], memory.scratch,
            )  # fmt: skip
            if behaviour.kind == UPPER_BOUND:
                memory.chosen[next_row + next_action] += 1
            after_choice(learner, memory, rules, memory.values[next_action] >= greatest(memory.values, n_actions))
            has_chosen = True
            if has_moved:
                continue
        row, action = next_row, next_action
        state = stage + cell
        cell, entry, outcome = _move(next_of, entries, memory.random, cell, stage, action, chance)
        kind = entry & KIND
        reward = reward_of[kind] if pay is None else earned(state, action, outcome, pay)
        terminal = kind == FINAL_GOAL
        stage += cells * (kind >> _1)
        next_row = entry ^ kind
        ended = terminal or time + 1 == rules.max_steps
        has_moved, has_chosen = True, False
        if len(trail.cells):
            counter += int(kind >= SUB_GOAL)
            trail.actions[at], trail.explored[at] = action, explores
            at += 1
            trail.cells[at], trail.counters[at] = cell, counter


@compiled
def _note_q(learner, memory, q_after, n_actions, width):
    """Record the Q-matrix, as the behaviour sees it."""
    for row in range(len(q_after)):
        show(learner, memory, index(row * width), n_actions)
        for action in range(n_actions):
            q_after[row, action] = memory.values[action]
