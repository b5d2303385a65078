"""Building a point from a recorded config runs no code that the config in use does not name."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import yaml

from rl_design_space.config import user_config
from rl_design_space.config.recorded import recorded_point
from rl_design_space.errors import ConfigError
from rl_design_space.plan.describe import resolved_config
from rl_design_space.plan.planner import Planner

#: A component that has been imported leaves a module behind.
COMPONENT = """
from dataclasses import dataclass
from rl_design_space.design import Torus

@dataclass(frozen=True)
class Size:
    value: int = 5

@dataclass(frozen=True)
class Ring(Torus):
    inner: Size = Size()
"""
RING = {"_target_": "mine_recorded.Ring", "size": 5, "inner": {"_target_": "mine_recorded.Size", "value": 7}}


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's module beside an empty config folder, which is not in use yet."""
    (tmp_path / "mine_recorded.py").write_text(COMPONENT)
    folder = tmp_path / "conf"
    (folder / "world").mkdir(parents=True)
    monkeypatch.setenv(user_config.VARIABLE, str(folder))
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    sys.modules.pop("mine_recorded", None)


@pytest.mark.parametrize("overrides", [[], ["representation=distance", "msa=lengths_2_3", "world=walled"]])
def test_a_recorded_point_is_built_again(planner: Planner, overrides: list[str]):
    point = planner(overrides).point
    assert recorded_point(resolved_config(point), "a run") == point


@pytest.mark.parametrize("prefix", ["rl_design_space", "rl_design_space.design", "rl_design_space.design.world"])
def test_every_name_of_a_shipped_class_is_known(prefix: str):
    assert recorded_point({"world": {"_target_": f"{prefix}.Torus", "size": 7}}, "a run").world.shape == (7, 7)


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ("world: {_target_: mine_recorded.Ring}", "world._target_=mine_recorded.Ring: comes from the store"),
        (
            "world: {_target_: rl_design_space.design.Torus, size: {_target_: mine_recorded.Ring}}",
            "world.size._target_",
        ),
        (
            "world: {_target_: rl_design_space.design.Torus, size: [{_target_: mine_recorded.Ring}]}",
            "world.size._target_",
        ),
        (
            "world: {_target_: rl_design_space.design.Torus, size: 5, x: {_target_: mine_recorded.Ring}}",
            "world.x._target",
        ),
        ("task: {a: {b: {_target_: mine_recorded.Ring}}}", "task.a.b._target_"),
        ("seed: {_target_: mine_recorded.Ring}", "seed._target_"),
        ("world: {_target_: [mine_recorded.Ring]}", "comes from the store"),
        ("world: {_target_: rl_design_space.__main__.Torus}", "comes from the store"),
        ("world: {_target_: rl_design_space._paths.sys.exit}", "comes from the store"),
        ("world: {_target_: rl_design_space.design.world.np}", "comes from the store"),
        ("world: {_target_: rl_design_space.design.Torus, _args_: [1]}", "world._args_: no such key"),
        ("world: {_target_: rl_design_space.design.Task}", "should be an instance of World"),
        ("world: {_target_: rl_design_space.design.Torus, sise: 5}", "did you mean world.size?"),
        ("seed: ${oc.env:HOME}", "seed=${oc.env:HOME}: should be a valid integer"),
        ("hydra: {}", "not the config of a design point"),
        ("nothing", "not the config of a design point"),
    ],
)
def test_anything_else_is_refused_without_running_it(own: Path, config: str, message: str):
    with pytest.raises(ConfigError) as caught:
        recorded_point(yaml.safe_load(config), "run 1")
    assert message in str(caught.value)
    assert str(caught.value).startswith("run 1: ")
    assert "\n" not in str(caught.value)
    assert "mine_recorded" not in sys.modules


def test_the_config_folder_in_use_allows_the_components_that_it_names_for_a_choice(own: Path):
    (own / "world" / "ring.yaml").write_text(yaml.safe_dump(RING))
    (own / "world" / "broken.yaml").write_text("[")
    world = recorded_point({"world": RING}, "a run").world
    assert (world.shape, world.inner.value) == ((5, 5), 7)
    with pytest.raises(ConfigError, match=r"reward\._target_=mine_recorded\.Ring: comes from the store"):
        recorded_point({"reward": RING}, "a run")
