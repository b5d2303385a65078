"""The plain learner of `reference`, with the other learners and behaviours: single steps, dictionaries, lists.

It shares no code with the package, except the rules of closed loops, which are part of the components.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from rl_design_space import design
from rl_design_space.design import DesignPoint
from tests import reference
from tests.reference import Period
from tests.reference_functions import exponential, logarithm
from tests.reference_streams import HALF, Xoshiro, generator_of, layout_of


@dataclass
class Agent:
    """An agent in one period: what it knows, and how it behaves in this trial."""

    point: DesignPoint
    generator: Xoshiro
    q: dict
    second: dict
    trial: int = 0
    level: float = 0.0
    updates: dict = field(default_factory=lambda: defaultdict(int))
    chosen: dict = field(default_factory=lambda: defaultdict(int))
    traces: dict = field(default_factory=dict)
    model: dict = field(default_factory=dict)
    met: list = field(default_factory=list)
    ring: list = field(default_factory=list)
    memory: dict = field(default_factory=lambda: defaultdict(float))

    @property
    def learner(self):
        return self.point.learner

    @property
    def doubles(self) -> bool:
        return isinstance(self.learner, design.DoubleQ)

    def seen(self, state) -> list[float]:
        """Q-values as the behaviour sees them."""
        if not self.doubles:
            return list(self.q[state])
        return [0.5 * (one + other) for one, other in zip(self.q[state], self.second[state], strict=True)]

    def alpha(self, state, action) -> float:
        """α of an update that is counted already."""
        learner = self.learner
        alpha = learner.alpha
        if learner.alpha_schedule == "linear":
            return max(alpha - learner.alpha_fall * self.trial, 0.0)
        if learner.alpha_schedule == "constant":
            return alpha
        count = self.updates[state, action]
        if learner.alpha_schedule == "visits":
            return alpha * (1.0 / count)
        return alpha * exponential(-learner.alpha_power * logarithm(count))

    def judged(self, state) -> list[float]:
        """Values with their bonus."""
        values = self.seen(state)
        if not isinstance(self.point.exploration, design.UpperConfidenceBound):
            return values
        counts = [self.chosen[state, action] for action in range(len(values))]
        total = logarithm(sum(counts)) if any(counts) else 0.0
        return [
            value + self.level * math.sqrt(total / count) if count else math.inf
            for value, count in zip(values, counts, strict=True)
        ]

    def weights(self, state) -> list[float]:
        values = self.seen(state)
        return [exponential((value - max(values)) / self.level) for value in values]

    def choose(self, state) -> int:
        word, behaviour = self.generator.next_word(), self.point.exploration
        if isinstance(behaviour, design.Softmax):
            weights = self.weights(state)
            action, below = 0, weights[0]
            total = 0.0
            for weight in weights:
                total += weight
            while action < len(weights) - 1 and not (word >> 11) * 2.0**-53 * total < below:
                action += 1
                below += weights[action]
        elif isinstance(behaviour, design.UpperConfidenceBound):
            action = reference.choose(self.judged(state), 0.0, word, self.learner)
            self.chosen[state, action] += 1
        else:
            action = reference.choose(self.seen(state), self.level, word, self.learner)
        if self.traces and isinstance(self.learner, design.QLambda):
            greedy = self.seen(state)[action] == max(self.seen(state))
            factor = self.learner.gamma * self.learner.trace_decay
            fallen = {entry: factor * trace for entry, trace in self.traces.items()} if greedy else {}
            self.traces = {entry: trace for entry, trace in fallen.items() if trace >= 1e-8}
        return action

    def probabilities(self, state) -> list[float]:
        if isinstance(self.point.exploration, design.Softmax):
            weights = self.weights(state)
            total = 0.0
            for weight in weights:
                total += weight
            return [weight / total for weight in weights]
        values = self.judged(state)
        epsilon = 0.0 if values != self.seen(state) else round(self.level * HALF) / HALF
        if isinstance(self.point.exploration, design.UpperConfidenceBound):
            epsilon = 0.0
        maxima = [action for action, value in enumerate(values) if value == max(values)]
        maxima = maxima[:1] if self.learner.ties == "first" else maxima
        found = []
        for action in range(len(values)):
            share = 1.0 / len(maxima) if action in maxima else 0.0
            others = 1.0 / len(values) if self.learner.explore == "all" else (1.0 - share) / (len(values) - 1)
            found.append((1.0 - epsilon) * share + epsilon * others)
        return found

    def mean(self, state) -> float:
        mean = 0.0
        for probability, value in zip(self.probabilities(state), self.q[state], strict=True):
            mean += probability * value
        return mean

    def update(self, state, action, error) -> float:
        """Count an update, and add α·error."""
        self.updates[state, action] += 1
        self.q[state][action] += self.alpha(state, action) * error
        return error

    def learn_greedily(self, state, action, reward, following) -> float:
        learner, old = self.learner, self.q[state][action]
        best = 0.0 if following is None else max(self.q[following])
        if getattr(learner, "update", "") == "printed":
            return self.update(state, action, reward + learner.gamma * (best - old))
        return self.update(state, action, reward + learner.gamma * best - old)


def learn_step(agent: Agent, time, state, action, reward, following, next_action, ended) -> float:
    """Learn from a step, by what its learner is; return its error."""
    learner, q, gamma = agent.learner, agent.q, agent.learner.gamma
    old = q[state][action]
    if isinstance(learner, design.Sarsa):
        value = 0.0 if following is None else q[following][next_action]
        return agent.update(state, action, reward + gamma * value - old)
    if isinstance(learner, design.ExpectedSarsa):
        value = 0.0 if following is None else agent.mean(following)
        return agent.update(state, action, reward + gamma * value - old)
    if isinstance(learner, design.DoubleQ):
        return _double(agent, state, action, reward, following)
    if isinstance(learner, design.NStep):
        return _several_steps(agent, time, state, action, reward, following, next_action, ended)
    if isinstance(learner, design.QLambda):
        agent.updates[state, action] += 1
        before = agent.traces.get((state, action), 0.0)
        agent.traces[state, action] = before + 1.0 if learner.traces == "accumulating" else 1.0
        error = reward + gamma * (0.0 if following is None else max(q[following])) - old
        for (at, choice), trace in agent.traces.items():
            q[at][choice] += agent.alpha(at, choice) * error * trace
        return error
    error = agent.learn_greedily(state, action, reward, following)
    if isinstance(learner, design.DynaQ):
        if state not in agent.model:
            agent.met.append(state)
            agent.model[state] = {}
        agent.model[state][action] = (reward, following)
        for _ in range(learner.planning):
            upper, lower = divmod(agent.generator.next_word(), HALF)
            begun = agent.met[upper * len(agent.met) // HALF]
            known = sorted(agent.model[begun])
            chosen = known[lower * len(known) // HALF]
            agent.learn_greedily(begun, chosen, *agent.model[begun][chosen])
    return error


def _double(agent: Agent, state, action, reward, following) -> float:
    word = agent.generator.next_word()
    learns, judges = (agent.q, agent.second) if word >> 63 else (agent.second, agent.q)
    value = 0.0
    if following is not None:
        best = reference.choose(learns[following], 0.0, word % HALF, agent.learner)
        value = judges[following][best]
    error = reward + agent.learner.gamma * value - learns[state][action]
    agent.updates[state, action] += 1
    learns[state][action] += agent.alpha(state, action) * error
    return error


def _several_steps(agent: Agent, time, state, action, reward, following, next_action, ended) -> float:
    learner, gamma = agent.learner, agent.learner.gamma
    agent.ring.append((state, action, reward))
    first = max(time - learner.n + 1, 0)
    error = 0.0
    for began in range(first, time + 1) if ended else [first] if time >= learner.n - 1 else []:
        path = agent.ring[began:]
        at, choice, _ = path[0]
        if learner.backup == "tree":
            target = path[-1][2] + gamma * (0.0 if following is None else agent.mean(following))
            for (_, _, gain), (there, taken, _) in reversed(list(pairwise(path))):
                share = agent.probabilities(there)[taken]
                target = gain + gamma * (agent.mean(there) + share * (target - agent.q[there][taken]))
        else:
            target, discount = 0.0, 1.0
            for _, _, gain in path:
                target += discount * gain
                discount *= gamma
            if following is not None:
                target += discount * agent.q[following][next_action]
        error = agent.update(at, choice, target - agent.q[at][choice])
    return error


def learn_period(point: DesignPoint, period: int) -> Period:
    """All trials of a period."""
    layout = layout_of(point, period)
    codes = point.representation.observation(point.world, np.array(layout[1:])).tolist()
    first = initial_q(point)
    q = {code: [first] * 4 for of_counter in codes for code in of_counter}
    agent = Agent(point, generator_of(point, period), q, {code: list(values) for code, values in q.items()})
    result = Period([], [], q)
    levels = point.exploration.schedule(point.task.trials).tolist()
    error = 0.0
    for trial in range(point.task.trials):
        agent.trial = trial
        if not isinstance(point.exploration, design.ClosedLoop):
            agent.level = levels[trial]
        elif trial == 0:
            agent.level = levels[0]
        else:
            made, succeeded = result.steps[-1], result.success[-1]
            counters = design.Counters(trial, agent.level, sum(result.success), succeeded, made, error / made)
            agent.level = min(max(point.exploration.rule(counters, point.exploration.parameters), 0.0), 1.0)
        steps, solved, error = _play_trial(agent, layout, codes)
        result.steps.append(steps)
        result.success.append(solved)
    for code in q if agent.doubles else ():
        q[code] = agent.seen(code)
    return result


def initial_q(point: DesignPoint) -> float:
    behaviour = point.exploration
    if isinstance(behaviour, design.Optimistic):
        _, sub_goal, final_goal = point.reward.table().tolist()
        return behaviour.scale * ((point.task.goals - 1) * sub_goal + final_goal)
    return point.learner.initial_q


def _play_trial(agent: Agent, layout, codes) -> tuple[int, bool, float]:
    point, (cell, *goals) = agent.point, layout
    step_of, reward_of = reference.steps_of(point), reference.rewards_of(point, goals)
    chooses_first = isinstance(point.learner, design.Sarsa) or (
        isinstance(point.learner, design.NStep) and point.learner.backup == "sarsa"
    )
    agent.traces, agent.ring = {}, []
    reached, time, total = 0, 0, 0.0
    state = codes[0][cell]
    action = agent.choose(state)
    while True:
        before, (cell, outcome) = cell, step_of(action, cell, agent.generator)
        reward = reward_of(reached, action, before, outcome, cell)
        reached += cell == goals[reached]
        solved = reached == len(goals)
        following = None if solved else codes[reached][cell]
        ended = solved or time + 1 == point.task.max_steps
        next_action = agent.choose(following) if chooses_first and not solved else None
        total += abs(learn_step(agent, time, state, action, reward, following, next_action, ended))
        time += 1
        if ended:
            return time, solved, total
        state = following
        action = next_action if chooses_first else agent.choose(state)
