"""Watkins's Q(λ): the error of a step is learned by all entries with a trace, which are kept in a list."""

from __future__ import annotations

from rl_design_space.learning.compiled import uncounted
from rl_design_space.learning.sequential.memory import count_update, step_size
from rl_design_space.learning.sequential.method import ACCUMULATING

#: A trace below this is dropped.
LEAST_TRACE = 1e-8


@uncounted
def learn_with_traces(learner, memory, rules, alpha, power, entry, gain, value):
    """Learn from a reward and the greatest value of the next observation; return the error."""
    q, traces, traced = memory.q, memory.other, memory.places
    count_update(memory.updates, power, entry)
    if traces[entry] == 0.0:
        traced[memory.size[0]] = entry
        memory.size[0] += 1
    traces[entry] = traces[entry] + 1.0 if learner.kind == ACCUMULATING else 1.0
    error = gain + rules.gamma * value - q[entry]
    for place in range(memory.size[0]):
        at = traced[place]
        q[at] += step_size(alpha, memory.updates, power, at) * error * traces[at]
    return error


@uncounted
def decay_traces(memory, factor):
    """Let all traces fall by a factor; 0 ends them."""
    traces, traced = memory.other, memory.places
    kept = 0
    for place in range(memory.size[0]):
        at = traced[place]
        trace = factor * traces[at]
        traces[at] = 0.0
        if trace >= LEAST_TRACE:
            traces[at] = trace
            traced[kept] = at
            kept += 1
    memory.size[0] = kept
