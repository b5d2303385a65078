"""YAML lists in the block of a study: sweeps, unless the key takes a list."""

from __future__ import annotations

import pytest

from rl_design_space.errors import ConfigError


@pytest.mark.parametrize(
    ("sweeps", "names"),
    [
        ({"representation": ["ad_hoc", "direction"]}, ["representation=ad_hoc", "representation=direction"]),
        ({"seed": [0, 3]}, ["seed=0", "seed=3"]),
        ({"task.goals": [1, 2]}, ["task.goals=1", "task.goals=2"]),
        ({"learner.ties": ["random", "first"]}, ["learner.ties=random", "learner.ties=first"]),
        ({"exploration": ["linear"], "exploration.k": [0.1]}, ["exploration=linear exploration.k=0.1"]),
        ({"msa.lengths": [2, 3]}, ["msa.lengths=[2,3]"]),
        ({"msa.lengths": []}, ["msa.lengths=[]"]),
        ({"msa.lengths": [[2], [2, 3]]}, ["msa.lengths=[2]", "msa.lengths=[2,3]"]),
        ({"world.size": [4, 5]}, ["world.size=[4,5]"]),
        ({"world.size": [10, [4, 5]]}, ["world.size=10", "world.size=[4,5]"]),
    ],
    ids=str,
)
def test_a_list_is_a_sweep_unless_the_key_takes_one(planned, sweeps: dict[str, object], names: list[str]):
    assert [p.name for p in planned({"a": sweeps})] == names


def test_the_type_of_a_key_is_that_of_the_option_on_the_command_line(planned):
    found = planned({"a": {"exploration.l": [1, 2]}}, "exploration=exponential")
    assert [p.name for p in found] == [f"exploration.l={value} exploration=exponential" for value in (1, 2)]


@pytest.mark.parametrize(
    ("sweeps", "message"),
    [
        ({"seed": []}, r"seed=\[\]: matches nothing"),
        ({"seed": ["range(0,2)", 5]}, "a sweep cannot be one of several values"),
        ({"representation": ["ad_hoc", "ad_hic"]}, "did you mean representation=ad_hoc"),
        ({"exploration": ["linear"], "exploration.kk": [1]}, "did you mean exploration.k"),
        ({"world.size": [4, 5, 6]}, r"world.size=\[4, 5, 6\]: a size is"),
    ],
    ids=str,
)
def test_an_invalid_list_is_explained(planned, sweeps: dict[str, object], message: str):
    with pytest.raises(ConfigError, match=f"study mine, block a: .*{message}"):
        planned({"a": sweeps})
