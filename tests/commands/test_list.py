"""`rl-design-space list`: all options, and what is wrong with those that cannot be used."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rl_design_space._paths import CONF
from rl_design_space.catalogue import choices
from rl_design_space.catalogue.studies import count_points
from rl_design_space.commands import words
from rl_design_space.errors import ConfigError

Said, Told = Callable[..., str], Callable[..., Any]


def test_every_shipped_option_is_listed_with_its_description(told: Told):
    found = told("list")
    files = {(file.parent.name, file.stem) for file in CONF.glob("*/*.yaml")}
    assert {(group, name) for group, each in found.items() for name in each["options"]} == files
    for group, each in found.items():
        assert each["description"], group
        for name, option in each["options"].items():
            assert option["description"], name
            assert option["file"] == str(CONF / group / f"{name}.yaml")
            assert set(option) == {"description", "file"}


def test_the_defaults_are_those_that_hydra_takes(told: Told, planner):
    chosen = planner.composer.config(["study=fig2"]).hydra.runtime.choices
    found = told("list")
    assert {group: each["default"] for group, each in found.items()} == {**{g: chosen[g] for g in found}, "study": None}


def test_a_table_lists_the_options_of_a_choice(said: Said):
    lines = said("list", "world").splitlines()
    assert lines[0] == "choice option description"
    assert lines[2] == "world where the agent moves."
    assert {
        "torus (default) Grid with periodic boundary, as in the paper",
        "walled Grid with walls around it: a step into the wall leaves the agent where it is",
    } <= set(lines[3:])


def test_studies_are_counted(told: Told, own: Path, monkeypatch: pytest.MonkeyPatch):
    # Planning all shipped studies takes seconds; the command of docs/configs.md does it.
    few = {"table4", "fig1", "mine", "both", "wrong"}
    monkeypatch.setattr(choices, "count_points", lambda *study: count_points(*study) if study[1] in few else 0)
    found = told("list", "study", "--config-dir", str(own))["study"]["options"]
    assert found["table4"]["points"] == 18
    assert found["fig1"]["points"] == 0
    assert found["mine"] == {
        "description": "A study of one's own",
        "file": str(own / "study" / "mine.yaml"),
        "points": 3,
    }
    assert found["both"]["points"] == 21
    assert found["wrong"]["error"].startswith("study wrong, block small: world.size=0: a size is a whole number")
    assert "points" not in found["wrong"]


def test_the_launchers_of_hydra_are_listed_when_asked_for(told: Told):
    options = told("list", "hydra/launcher")["hydra/launcher"]["options"]
    assert options["design"]["description"] == "Learns on the threads of this process"
    assert "basic" in options


@pytest.mark.parametrize(
    ("name", "description", "error"),
    [
        ("near", "Whether the due goal is near", ""),
        ("commented", "My own one, as it is", ""),
        ("child", "Built on another", ""),
        ("not_yaml", "Not even YAML", "not YAML: "),
        ("nowhere", "", "_target_=nowhere.Near: cannot be imported: No module named 'nowhere'"),
        ("raises", "Raises", "not today"),
        ("function", "", "_target_=own_parts.function: should name a class"),
        ("misspelt", "Misspelt", "representation.ruel: no such key; did you mean representation.rule?"),
        ("open", "To be filled in", "representation.radius=???: needs a value"),
    ],
)
def test_an_option_that_cannot_be_used_has_a_reason(name: str, description: str, error: str, told: Told, own: Path):
    option = told("list", "representation", "-cd", str(own))["representation"]["options"][name]
    assert option["description"] == description
    assert error in option.get("error", "")
    assert bool(error) == ("error" in option)


def test_an_option_that_cannot_be_used_is_marked_in_the_table(said: Said, own: Path):
    text = said("list", "exploration", "--config-dir", str(own))
    assert "steep [bold]Steep[/bold]\ncannot be used: exploration.start=1.5: should be less than or equal to 1" in text


def test_folders_of_the_search_path_are_searched(told: Told, own: Path):
    quoted = str(own).replace("'", "\\'")
    assert (
        "near" in told("list", "representation", f"hydra.searchpath=['file://{quoted}']")["representation"]["options"]
    )


def test_choices_of_ones_own_are_listed(told: Told, own: Path):
    found = told("list", "--config-dir", str(own))
    assert found["experiment"]["options"]["first"]["description"] == "An experiment"
    assert list(found)[-1] == "experiment"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["wordl"], "wordl: no such choice; did you mean world?"),
        (["world", "--config-dir", "nowhere"], "--config-dir nowhere: there is no such folder"),
        (["world", "seed=1"], "seed=1: list accepts no override"),
        (["seed=1"], "seed=1: list accepts no override"),
        (
            ["world", "torus"],
            "torus: not an override; overrides look like key=value, e.g. task.periods=50; to show one",
        ),
    ],
)
def test_a_mistake_is_reported_with_a_correction(arguments: list[str], message: str):
    with pytest.raises(ConfigError) as raised:
        words.run("list", arguments)
    assert str(raised.value).startswith(message)
