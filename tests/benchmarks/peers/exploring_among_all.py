"""Learns another job: its exploratory actions are drawn among all actions, the greedy one included."""

from dataclasses import replace

import rl_design_space
from benchmarks.peers import ours
from rl_design_space.design import QLearning

TITLE = "exploring among all"
PERIODS = 500


def version():
    return "wrong 1"


def prepare(job):
    def learn(layouts, seed):
        point = ours.point(job, len(layouts), seed)
        wrong = replace(point, learner=QLearning(alpha=job.alpha, gamma=job.gamma, explore="all"))
        return rl_design_space.simulate(wrong, threads=1).total_steps.astype(int)

    return learn
