"""Command lines: the arguments that Hydra gets, those that the points of a sweep get, and those that are refused."""

from __future__ import annotations

import pytest

from rl_design_space.commands.command_line import CommandLine, read_command_line
from rl_design_space.errors import ConfigError


@pytest.mark.parametrize(
    ("argument", "for_hydra"),
    [
        ("task.periods=5", "++task.periods=5"),
        ("++seed=1", "++seed=1"),
        ("+learner.extra=1", "++learner.extra=1"),
        ("representation=direction", "representation=direction"),
        ("+setup=hard", "+setup=hard"),
        ("~world", "~world"),
        # Left to the points: values that are swept over, and whether there is a key.
        ("world.size=4,5", None),
        ("+setup=hard,easy", None),
        ("~world.size", None),
        ("msa.lengths.0=3", None),
        ("outputs=x", "outputs=x"),
        ("tracking=none", "tracking=none"),
        ("tracking.uri=sqlite:///x.db", "tracking.uri=sqlite:///x.db"),
        ("~tracking", "~tracking"),
        ("plan=true", "plan=true"),
        ("hydra.verbose=true", "hydra.verbose=true"),
        ("hydra/launcher=basic", "hydra/launcher=basic"),
        ("threads=1,2", "threads=1,2"),  # refused later
        ("study.report.title=x", "study.report.title=x"),
        ("~study.blocks.direction", "~study.blocks.direction"),
        ("--config-dir=mine", "--config-dir=mine"),
    ],
)
def test_hydra_gets_what_all_points_of_a_sweep_share(argument: str, for_hydra: str | None):
    line = read_command_line(["study=table4", argument])
    assert set(line.for_hydra) == {"--multirun", "study=table4", *filter(None, [for_hydra])}
    assert line.typed == ("study=table4", argument)


@pytest.mark.parametrize(
    ("arguments", "for_hydra"),
    [
        (["-m", "seed=1,2"], ["-m"]),
        (["--multirun", "seed=1,2"], ["--multirun"]),
        (["hydra.mode=MULTIRUN", "seed=1,2"], ["--multirun", "hydra.mode=MULTIRUN"]),
        (["study=table4,fig3", "seed=1"], ["--multirun", "study=table4,fig3", "seed=1"]),
        (["plan=true", "seed=1"], ["--multirun", "plan=true", "seed=1"]),
        (["shard=1/2", "seed=1"], ["--multirun", "shard=1/2", "seed=1"]),
        (["study=table4", "--config-dir", "mine"], ["--multirun", "--config-dir", "mine", "study=table4"]),
        (["hydra/sweeper=design", "-m", "seed=1,2"], ["-m", "hydra/sweeper=design"]),
    ],
    ids=str,
)
def test_a_study_a_plan_and_a_shard_imply_multirun(arguments: list[str], for_hydra: list[str]):
    assert list(read_command_line(arguments).for_hydra) == for_hydra


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["task.periods=5", "world.size=4"],
        ["plan=false", "shard=null"],
        ["-m", "hydra/sweeper=basic", "seed=1,2"],
        ["-m", "hydra/sweeper=optuna", "exploration=linear"],
        ["--cfg", "job", "seed=1"],
        ["--help"],
        ["--info", "plugins"],
    ],
    ids=str,
)
def test_all_other_arguments_go_to_hydra_unchanged(arguments: list[str]):
    line = read_command_line(arguments)
    runs = not {"--cfg", "--info", "--help", "--hydra-help"} & set(arguments)
    overrides = tuple(argument for argument in arguments if "=" in argument)
    assert line == CommandLine(tuple(arguments), overrides, tuple(arguments), foreign="-m" in arguments, runs=runs)


def test_study_null_is_kept_from_hydra():
    assert read_command_line(["study=null", "seed=1"]).for_hydra == ("seed=1",)
    assert read_command_line(["-m", "study=null", "seed=1,2"]).for_hydra == ("-m",)


def test_a_study_can_be_shown_without_being_run():
    line = read_command_line(["study=table4", "world.size=5", "--cfg", "job"])
    assert line.for_hydra == ("--cfg", "job", "study=table4", "world.size=5")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-m", "--cfg", "job"], "--multirun and --cfg cannot be used together"),
        (["-m", "--info"], "--multirun and --info cannot be used together"),
        (["study=table4", "hydra/sweeper=basic"], "study=table4 needs hydra/sweeper=design, not basic"),
        (["plan=true", "hydra/sweeper=optuna"], "plan=true needs hydra/sweeper=design, not optuna"),
        (["shard=1/2", "-m", "hydra/sweeper=basic"], "shard=1/2 needs hydra/sweeper=design, not basic"),
        (["world=10"], "world=10: name exactly one option"),
        (["world=${oc.select:nope,1}"], "world=${oc.select:nope,1}: name exactly one option"),
        (["outputs=x", "store", "status"], "the first argument, as in `rl-design-space store status outputs=x`"),
        (["-m", "sho", "world"], "sho: not an override; did you mean `rl-design-space show`?"),
        (["seed=1", "quick"], "quick: not an override; overrides look like key=value"),
        (["-m", "hydra/sweeper=basic", "seed=range(0,100001)"], "100,001 combinations, more than max_points=100000"),
        (["world.size=[10"], 'world.size=[10: character 12, "[", is not closed'),
    ],
    ids=str,
)
def test_contradicting_arguments_are_refused(arguments: list[str], message: str):
    with pytest.raises(ConfigError) as caught:
        read_command_line(arguments)
    assert message in str(caught.value)


def test_the_command_is_quoted_for_a_shell():
    line = read_command_line(["study=table4", "world.size=[4, 5]"])
    assert line.command == "rl-design-space study=table4 'world.size=[4, 5]'"


@pytest.mark.parametrize(
    ("arguments", "only_planned"),
    [
        (["plan=true", "seed=1"], True),
        (["-m", "plan=true", "seed=1,2"], False),
        (["hydra.mode=MULTIRUN", "plan=true"], False),
        (["plan=true", "study=table4"], False),
        (["plan=true", "shard=1/2"], False),
        (["seed=1"], False),
    ],
)
def test_a_plan_of_what_would_be_a_single_run_is_told_apart(arguments: list[str], only_planned: bool):
    assert read_command_line(arguments).only_planned is only_planned
