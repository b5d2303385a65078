"""Every shipped option keeps its contract, at every named value and at the limits of its ranges."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.config.compose import OPTION_GROUPS
from rl_design_space.contracts import (
    check_carry,
    check_curriculum,
    check_exploration,
    check_learner,
    check_msa,
    check_representation,
    check_reward,
    check_study,
    check_world,
)
from rl_design_space.design import (
    AdHoc,
    Aggregated,
    Controllers,
    Direction,
    Distance,
    Exponential,
    Linear,
    MultiStepActions,
    Scene,
    Torus,
    Walled,
    Without,
)
from rl_design_space.plan.planner import Planner
from tests.command_runner import PATIENCE, python
from tests.design.options import names_of, overrides_of, variations
from tests.misfits import misfit

ROOT = Path(__file__).parents[2]

CHECKS = {
    "world": check_world,
    "representation": check_representation,
    "exploration": check_exploration,
    "msa": check_msa,
    "reward": check_reward,
    "curriculum": check_curriculum,
    "learner": check_learner,
}
SHIPPED = [pytest.param(group, name, id=f"{group}={name}") for group in CHECKS for name in names_of(group)]
#: Beside the shipped options and the limits of their ranges.
UNUSUAL = [
    (check_world, Torus(size=(100, 3))),
    (check_world, Walled(size=(2, 9))),
    (check_world, misfit(Walled(size=3), open_cells=lambda self: np.array([0, 1, 3], dtype=np.int32))),
    (check_exploration, Exponential(start=0.01, l=0.5)),
    (check_representation, Aggregated(block=(2, 1))),
    (check_representation, Without(of=Distance(goals="due"), leave_out=("goal1",), counters=(0,))),
    (check_representation, Without(of=AdHoc(), leave_out=("counter", "x"))),
    (check_msa, MultiStepActions(lengths=(5, 2, 3))),
    (check_msa, MultiStepActions(lengths=(4,), until="observation_changes")),
    (check_msa, Controllers(controllers=("back_to_sub_goal", "along_wall"), primitives=False)),
]


@pytest.mark.parametrize(("group", "name"), SHIPPED)
def test_a_shipped_option_keeps_its_contract(group: str, name: str, planner: Planner):
    option = getattr(planner(overrides_of(group, name)).point, group)
    CHECKS[group](option)
    for variation in variations(option):
        CHECKS[group](variation)


def test_the_variations_of_an_option_are_those_of_its_annotations():
    varied = set(variations(Direction()))
    assert varied == {
        Direction(rule=rule, goals=goals)
        for rule in ("dominant_axis", "horizontal_first")
        for goals in ("all", "remaining", "due")
    }
    assert {Linear(start=0), Linear(start=1), Linear(k=0)} <= set(variations(Linear()))
    assert Torus(size=2) in variations(Torus())


def test_every_choice_has_a_contract_and_options():
    assert set(CHECKS) == set(OPTION_GROUPS)
    assert all(names_of(group) for group in CHECKS)


@pytest.mark.parametrize(
    ("check", "component"), UNUSUAL, ids=lambda value: getattr(value, "__name__", None) or str(value)
)
def test_unusual_values_keep_the_contract(check, component):
    check(component)


def same_cell(before: Scene, after: Scene) -> np.ndarray:
    """Carry the values of the cell of equal number, where there is one."""
    cells = np.arange(after.codes.shape[2])
    ancestors = np.arange(after.codes.shape[1])[:, np.newaxis] * before.codes.shape[2] + cells
    return np.broadcast_to(np.where(cells < before.codes.shape[2], ancestors, -1), after.codes.shape)


def test_a_carry_rule_keeps_its_contract():
    check_carry(same_cell)
    with pytest.raises(AssertionError, match=r"<lambda>\(\) should give whole numbers of shape \(2, 2, 16\)"):
        check_carry(lambda before, after: after.codes[0])


def test_a_representation_can_be_checked_in_given_worlds():
    check_representation(Distance(), worlds=[Torus(size=30), Walled(size=(2, 40))])


def test_a_study_keeps_its_contract_if_it_can_be_planned():
    check_study("table4")
    with pytest.raises(AssertionError, match="study=tabel4: no such option; did you mean study=table4"):
        check_study("tabel4")


def test_checks_survive_an_optimised_interpreter():
    program = (
        "from rl_design_space.contracts import check_reward\n"
        "from rl_design_space.design import Constant\n"
        "check_reward(Constant())"
    )
    command = [sys.executable, "-O", "-c", program]
    checked = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=PATIENCE)
    assert "Constant must have every member of Reward" in checked.stderr


def test_a_contract_is_importable_without_the_test_framework():
    program = "import sys, rl_design_space.contracts; print({'pytest', 'hypothesis', 'numba'} & set(sys.modules))"
    assert python(program, cwd=ROOT).strip() == "set()"
