"""Thrown-together command lines: each describes points, or is refused with a message."""

from __future__ import annotations

import random
import signal
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import pytest

from rl_design_space.commands.command_line import read_command_line
from rl_design_space.config.explain import explain
from rl_design_space.config.overrides import is_setting
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import load_study, plan_overrides
from rl_design_space.run.settings import build_settings

#: Command lines drawn in one test, and the most points that one of them may plan.
DRAWN, MOST = 100, 20
#: Seconds after which a command line counts as hanging.
LIMIT = 20

SIGNS = ("", "", "", "", "+", "++", "~")
KEYS = (
    *("world", "representation", "exploration", "msa", "reward", "learner", "tracking", "study", "hydra/launcher"),
    *("hydra", "task", "seed", "task.goals", "world.size", "exploration.epsilon", "msa.lengths", "learner.ties"),
    *("reward.step", "world._target_", "outputs", "threads", "plan", "shard", "max_points", "tracking.uri", "nope"),
    *("study.blocks", "study.includes", "hydra.searchpath", "hydra.job.name", "task.x.y", "world@x", "tracking@_here_"),
)
VALUES = (
    *("1", "0", "-1", "1.5", "inf", "nan", "true", "null", "???", "''", '""', "[]", "{}", "[1,2]", "{a:1}", "[inf,1]"),
    *("torus", "ad_hoc", "linear", "none", "table4", "design", "a:b:c", "[torus]", "[[torus]]", "[???]", "[null]"),
    *("${seed}", "${nope}", "${oc.select:nope,1}", "${oc.env:NOPE}", "${oc.decode:[}", "${", "${.x}", "[${seed}]"),
    *("010", "1:30", "2020-99-99", "9" * 40, "1e400", "a b", "a=b", "a(b", "a#b", "'", "[", "}", "\\", "!!x"),
    *(
        "1,2",
        "range(0,3)",
        "range(0,10,0)",
        "range(0,inf)",
        "range(a,b)",
        "range(0,1000000)",
        "choice()",
        "choice(1,2)",
    ),
    *("glob(*)", "glob(x)", "interval(0,1)", "shuffle(1,2)", "sort(a,1)", "bool(1)", "int(a)", "tag(a,choice(1,2))"),
)


def drawn(numbers: random.Random) -> list[str]:
    """Draw a command line."""
    arguments = numbers.choice(([], [], ["-m"], ["plan=true"], ["-m", "hydra/sweeper=basic"]))
    for _ in range(numbers.choice((1, 1, 2, 3))):
        value = ",".join(numbers.choices(VALUES, k=numbers.choice((1, 1, 1, 2))))
        arguments = [*arguments, f"{numbers.choice(SIGNS)}{numbers.choice(KEYS)}={value}"]
    return arguments


def planned(arguments: Sequence[str], planner: Planner) -> None:
    """Plan a command line as the command does; raise the error that it would show."""
    line = read_command_line(arguments)
    if {"-m", "--multirun"} & set(line.for_hydra):
        most = [f"max_points={MOST}", *filter(is_setting, line.overrides)]
        build_settings(planner.composer.config([text for text in most if not text.startswith("study=")]))
        names = [text.removeprefix("study=") for text in line.overrides if text.startswith("study=")]
        for name in names:
            load_study(name, [f"max_points={MOST}", *line.overrides], planner)
        if not names:
            plan_overrides(line.overrides, planner, MOST)
    else:
        planner(line.overrides)


@contextmanager
def limited(seconds: int) -> Iterator[None]:
    """Raise an error if the context takes longer."""

    def stop(*_: object) -> None:
        raise TimeoutError(f"takes more than {seconds} s")

    before = signal.signal(signal.SIGALRM, stop)
    left = signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(left)
        signal.signal(signal.SIGALRM, before)


def refusal(arguments: Sequence[str], planner: Planner) -> str | None:
    """Return the message with which a command line is refused, or None if it is planned; any other error passes."""
    try:
        with limited(LIMIT):
            planned(arguments, planner)
    except Exception as error:
        if explained := explain(error):
            return str(explained)
        raise AssertionError(f"{arguments} raises {error!r}") from error
    return None


@pytest.mark.parametrize(
    "arguments",
    [
        ["world=[inf,1]"],
        ["-m", "learner.ties=range(0,10,0)"],
        ["hydra=bool(1)"],
        ["-m", 'representation="",a:b:c'],
        ["world=${oc.select:nope,1}"],
        ["exploration=[1,2]"],
        ["hydra/job_logging=[null]"],
        ["+world@x=[[torus]]"],
        ["representation=[???],0x1F"],
        ["~tracking=[${.0}]"],
        ["-m", "reward.step=range(0,1000000)"],
        ["-m", "hydra/sweeper=basic", "reward.step=range(0,1000000)"],
        ["-m", f"seed=range(0,{10**40})"],
        ["-m", "exploration.epsilon=range(0,inf)"],
    ],
    ids=" ".join,
)
def test_a_command_line_that_once_ended_in_a_traceback_or_never_is_refused(arguments: list[str], planner: Planner):
    assert refusal(arguments, planner)


def test_whatever_is_typed_is_planned_or_refused_with_a_message(planner: Planner):
    numbers = random.Random(0)
    messages = [refusal(drawn(numbers), planner) for _ in range(DRAWN)]
    assert None in messages
    assert "" not in messages
    assert len(set(messages)) > DRAWN / 10
