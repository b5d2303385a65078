"""Fingerprints: everything that changes results changes them, and nothing else does."""

from __future__ import annotations

import os
import string
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass, replace
from typing import Any, Literal, get_args, get_origin, get_type_hints

import pytest

from rl_design_space._paths import CONF
from rl_design_space.config.compose import OPTION_GROUPS
from rl_design_space.design import (
    AdHoc,
    Aggregated,
    DesignPoint,
    Linear,
    MultiStepActions,
    Refine,
    Stage,
    Task,
    Torus,
    Walled,
    Without,
)
from rl_design_space.design.identity import absent_as
from rl_design_space.errors import ConfigError
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.plan.describe import parameters, resolved_config
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.plan.planner import Planner
from tests.command_runner import python
from tests.design.options import overrides_of

#: Kernel version, and the fingerprint of the default point under it.
GOLDEN = (1, "ef0d1761b43fe76c45d030a54f963b74837b5aa94e15676d7908dce9238e27a5")


Of = Callable[..., str]


@pytest.fixture
def of(planner: Planner) -> Of:
    """Return the fingerprint of the point that these overrides describe."""
    return lambda *overrides: planner(overrides).fingerprint


def test_recorded_fingerprints_are_unchanged():
    version, expected = GOLDEN
    found = fingerprint(DesignPoint())
    assert (version, expected) == (KERNEL_VERSION, found), (
        "results stored under the old fingerprint of a point are not found any more. That is right if the same point "
        "now gives other results (KERNEL_VERSION was raised, or an option has a new default, or a new field without "
        "`absent_as`); otherwise "
        f"identical points are learned anew. If it is meant, record GOLDEN = ({KERNEL_VERSION}, {found!r})"
    )


def test_a_fingerprint_is_a_sha256():
    found = fingerprint(DesignPoint())
    assert len(found) == 64
    assert set(found) <= set(string.hexdigits.lower())


def test_the_kernel_version_changes_the_fingerprint(monkeypatch: pytest.MonkeyPatch):
    before = fingerprint(DesignPoint())
    monkeypatch.setattr("rl_design_space.plan.fingerprint.KERNEL_VERSION", KERNEL_VERSION + 1)
    assert fingerprint(DesignPoint()) != before


def test_the_fingerprint_is_the_same_in_another_process(of: Of):
    program = (
        "from rl_design_space.design import DesignPoint, Direction, MultiStepActions, Torus\n"
        "from rl_design_space.plan.fingerprint import fingerprint\n"
        "print(fingerprint(DesignPoint(representation=Direction(), msa=MultiStepActions(lengths=(3, 2)))))"
    )
    # Each process has its own hash seed, so the order of a set must not matter.
    found = [python(program, env={**os.environ, "PYTHONHASHSEED": seed}).strip() for seed in ("1", "2")]
    assert found == [of("representation=direction", "msa.lengths=[3,2]")] * 2


@pytest.mark.parametrize(
    ("one_way", "another"),
    [
        (["reward=many_rewards", "reward.step=0"], ["reward=each_success"]),
        (["reward=each_success", "reward.sub_goal=0.0"], ["reward=end_reward"]),
        (["msa=none", "msa.lengths=[3]"], ["msa=length_3"]),
        (["world.size=[10,10]"], ["world.size=10"]),
        (["exploration=exponential", "exploration.l=2"], ["exploration=exponential", "exploration.l=2.0"]),
        (["reward.step=-0.0"], ["reward.step=0.0"]),
        (["world=walled", "world._target_=rl_design_space.design.Torus"], ["world=torus"]),
        (["world._target_=rl_design_space.design.world.Walled"], ["world=walled"]),
        (["task.trials=${task.goals}", "task.goals=5"], ["task.goals=5", "task.trials=5"]),
        (["seed=3", "world.size=5"], ["world.size=5", "seed=3"]),
        # What a curriculum lists counts, not its class; one stage that is the point is none.
        (["curriculum=new_goals", "curriculum.layouts=1"], []),
        (["curriculum=new_goals", "curriculum.layouts=2"], ["curriculum.stages=[{},{layout: new}]"]),
        (["curriculum.stages=[{},{exploration: linear}]"], ["curriculum.stages=[{carry: none},{exploration: linear}]"]),
    ],
    ids=lambda overrides: " ".join(overrides),
)
def test_equal_points_have_one_fingerprint_however_they_are_written(one_way: list[str], another: list[str], of: Of):
    assert of(*one_way) == of(*another)


@pytest.mark.parametrize(
    "setting",
    ["tracking=none", "tracking.uri=http://nowhere", "tracking.curves=[epsilon]", "outputs=elsewhere", "threads=1"],
)
def test_settings_do_not_change_the_fingerprint(setting: str, of: Of):
    assert of(setting) == fingerprint(DesignPoint())


# Every field of every option.


def another_value(value: Any, kind: Any) -> Any:
    """Return another valid value of a field."""
    choices = [choice for choice in get_args(kind) if choice != value]
    match value:
        case "same":  # of a size
            return 7
        case None:  # no probability
            return 0.5
        case "same_place" | "same_observation":
            return "none"
        case () if kind == tuple[Stage, ...]:
            return (Stage(layout="new"),)
        case str() if get_origin(kind) is Literal and choices:
            return choices[0]
        case str():
            return f"{value}_also"
        case None:  # of a probability
            return 0.3
        case bool():
            return not value
        case int():
            return value + 1
        case float():
            return value / 2 if value else 0.5
        case tuple():
            return value[:-1] if value and isinstance(value[0], str) else (*value, 7)
    raise AssertionError(f"say here what another value than {value!r} is")


#: What else a field needs to be changed.
NEEDED = {"alpha_fall": {"alpha_schedule": "linear"}, "alpha_power": {"alpha_schedule": "polynomial"}}
#: Other values of fields that allow few.
ALLOWED = {
    Aggregated: {"block": 5},
    Refine: {"split": "all", "rows": 9, "times": 3, "trials": 7, "carry": "none"},
    Without: {"of": AdHoc(), "leave_out": ("goal1",), "counters": (1,)},
}


def changed(component: Any) -> Iterator[tuple[str, Any]]:
    """Yield copies of a component, each with one field changed."""
    kinds, allowed = get_type_hints(type(component)), ALLOWED.get(type(component), {})
    for one in fields(component):
        value = getattr(component, one.name)
        other = allowed[one.name] if allowed else another_value(value, kinds[one.name])
        yield one.name, replace(component, **{one.name: other}, **NEEDED.get(one.name, {}))


OPTIONS = [(group, file.stem) for group in OPTION_GROUPS for file in sorted((CONF / group).glob("*.yaml"))]


@pytest.mark.parametrize(("group", "option"), OPTIONS)
def test_every_field_of_an_option_changes_the_fingerprint(group: str, option: str, planner: Planner):
    point = planner(overrides_of(group, option)).point
    found = {"as it is": fingerprint(point)}
    for name, component in changed(getattr(point, group)):
        found[name] = fingerprint(replace(point, **{group: component}))
    assert len(set(found.values())) == len(found), found


def test_every_field_of_a_point_changes_the_fingerprint():
    point = DesignPoint()
    plain = [one.name for one in fields(point) if not is_dataclass(getattr(point, one.name))]
    assert plain == ["seed"]
    point = replace(point, task=replace(point.task, precision=0.02))  # which its other fields need
    found = [fingerprint(replace(point, task=task)) for _, task in changed(point.task)]
    found += [fingerprint(point), fingerprint(replace(point, seed=1))]
    assert len(set(found)) == len(found)


@pytest.mark.parametrize("group", OPTION_GROUPS)
def test_options_of_a_group_have_different_fingerprints(group: str, of: Of):
    found = {option: of(*overrides_of(group, option)) for kind, option in OPTIONS if kind == group}
    assert len(set(found.values())) == len(found)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (DesignPoint(seed=2**63), DesignPoint(seed=2**63 + 1)),
        (DesignPoint(exploration=Linear(k=0.1)), DesignPoint(exploration=Linear(k=0.1 + 2**-50))),
        (DesignPoint(msa=MultiStepActions(lengths=(2, 3))), DesignPoint(msa=MultiStepActions(lengths=(3, 2)))),
        (DesignPoint(world=Torus(size=(4, 5))), DesignPoint(world=Torus(size=(5, 4)))),
        (DesignPoint(world=Torus(size=4)), DesignPoint(world=Walled(size=4))),
        (DesignPoint(task=Task(trials=5, periods=6)), DesignPoint(task=Task(trials=6, periods=5))),
    ],
    ids=["seed", "float", "order", "axes", "class", "fields"],
)
def test_almost_equal_points_have_different_fingerprints(one: DesignPoint, other: DesignPoint):
    assert fingerprint(one) != fingerprint(other)


# User components.


def own_torus(module: str, name: str = "Torus") -> Torus:
    return make_dataclass(name, [], bases=(Torus,), frozen=True, namespace={"__module__": module, "__version__": 1})()


def test_components_with_the_same_name_differ_by_their_module():
    mine, yours = own_torus("mine"), own_torus("yours")
    found = {fingerprint(DesignPoint(world=world)) for world in (mine, yours, own_torus("mine", "Ring"), Torus())}
    assert len(found) == 4
    assert fingerprint(DesignPoint(world=own_torus("mine"))) == fingerprint(DesignPoint(world=mine))


def test_a_module_with_a_similar_name_is_not_shipped():
    assert fingerprint(DesignPoint(world=own_torus("rl_design_space_more"))) != fingerprint(DesignPoint())


@dataclass(frozen=True)
class Part:
    weight: float = 1.0


@dataclass(frozen=True)
class OwnWorld(Torus):
    parts: tuple[Part, ...] = (Part(), Part(weight=2.0))
    weights: dict[str, float] = field(default_factory=lambda: {"a": 1.0, "b": 2.0}, hash=False)


@pytest.mark.parametrize(
    "other",
    [
        OwnWorld(parts=(Part(), Part(weight=3.0))),
        OwnWorld(parts=(Part(),)),
        OwnWorld(weights={"a": 1.0}),
        OwnWorld(weights={"a": 1.0, "b": 3.0}),
    ],
    ids=["in a list", "length", "key", "in a mapping"],
)
def test_nested_values_of_a_component_change_the_fingerprint(other: OwnWorld):
    assert fingerprint(DesignPoint(world=other)) != fingerprint(DesignPoint(world=OwnWorld()))


def test_the_order_of_a_mapping_does_not_change_the_fingerprint():
    one, other = OwnWorld(weights={"a": 1.0, "b": 2.0}), OwnWorld(weights={"b": 2.0, "a": 1.0})
    assert fingerprint(DesignPoint(world=one)) == fingerprint(DesignPoint(world=other))


def test_a_field_without_a_plain_value_is_refused(tmp_path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "own_schedule.py").write_text(
        "from dataclasses import dataclass\n"
        "import numpy as np\n"
        "@dataclass(frozen=True)\n"
        "class Steps:\n"
        "    levels: object = frozenset((0.1, 0.2))\n"
        "    def schedule(self, trials):\n"
        "        return np.full(trials, max(self.levels))\n",
        encoding="utf-8",
    )
    monkeypatch.syspath_prepend(tmp_path)
    from own_schedule import Steps

    with pytest.raises(ConfigError, match="plain value"):
        fingerprint(DesignPoint(exploration=Steps()))


# Fields that are added later.


def grown(**later: object) -> type[Torus]:
    """Create a later version of the torus: the same name, with additional fields."""
    added = [(name, type(value.default), value) for name, value in later.items()]
    kind = make_dataclass("Torus", added, bases=(Torus,), frozen=True, kw_only=True)
    kind.__module__ = Torus.__module__
    return kind


def of_world(world: Torus) -> str:
    return fingerprint(replace(DesignPoint(), world=world))


def test_a_new_field_with_absent_as_keeps_fingerprints():
    windy = grown(wind=field(default=0.0, metadata=absent_as(0.0)), holes=field(default=(), metadata=absent_as(())))
    assert of_world(windy(size=7)) == of_world(Torus(size=7))
    assert of_world(windy(size=7, wind=-0.0)) == of_world(Torus(size=7))
    assert of_world(windy(size=7, wind=0.5)) != of_world(Torus(size=7))
    assert of_world(windy(size=7, holes=(3,))) != of_world(Torus(size=7))


def test_a_new_field_without_absent_as_changes_fingerprints():
    assert of_world(grown(wind=field(default=0.0))(size=7)) != of_world(Torus(size=7))


def test_a_later_default_does_not_change_the_value_that_stands_for_absence():
    windy = grown(wind=field(default=0.5, metadata=absent_as(0.0)))
    assert of_world(windy(size=7, wind=0.0)) == of_world(Torus(size=7))
    assert of_world(windy(size=7)) != of_world(Torus(size=7))


def test_a_field_that_is_not_listed_appears_once_it_has_another_value():
    point = DesignPoint()
    listed = set(parameters(point)) | set(resolved_config(point)["task"])
    assert not any("precis" in name or "at_most" in name for name in listed)
    asking = replace(point, task=replace(point.task, precision=0.02))
    assert parameters(asking)["task.precision"] == resolved_config(asking)["task"]["precision"] == 0.02
    assert "task.precision_of" not in parameters(asking)
    # An option of the user's shows its fields as ever.
    world = grown(wind=field(default=0.0, metadata=absent_as(0.0)))(size=7)
    assert parameters(replace(point, world=world))["world.wind"] == 0.0
