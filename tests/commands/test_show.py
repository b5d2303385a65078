"""`rl-design-space show`: options, studies, keys."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import pytest

from rl_design_space._paths import CONF
from rl_design_space.commands import words
from rl_design_space.errors import ConfigError

Said, Told = Callable[..., str], Callable[..., Any]

COMPONENTS = sorted(f"{f.parent.name}={f.stem}" for f in CONF.glob("*/*.yaml") if f.parent.name != "study")


@pytest.mark.parametrize("choice", COMPONENTS)
def test_every_parameter_of_a_shipped_option_is_explained(choice: str, told: Told):
    shown = told("show", choice)
    group = choice.partition("=")[0]
    expected = {f"{group}.{field.name}" for field in fields(resolve_name(shown["target"]))}
    assert set(shown["parameters"]) == expected
    for each in shown["parameters"].values():
        assert each["description"]
        assert each["schema"]
        assert "default" in each
    assert "error" not in shown


@pytest.mark.parametrize("text", ["exploration=linear", "exploration/linear"])
def test_an_option_is_shown_with_its_parameters(text: str, said: Said):
    lines = said("show", text).splitlines()
    assert lines[0] == "ε = max(start - k·τ, 0)"
    assert lines[1] == "parameter type range default description"
    assert lines[3:5] == [
        "exploration.start number 0 to 1 0.9 ε at τ = 0.",
        "exploration.k number at least 0 0.03 decrease of ε per trial; the paper tries 0.01 to 0.1.",
    ]
    assert lines[-2:] == ["class: rl_design_space.design.Linear", f"file: {CONF}/exploration/linear.yaml"]


def test_an_option_without_parameters(said: Said):
    assert "no parameters" in said("show", "representation=ad_hoc")


def test_a_long_value_is_shortened_in_the_terminal_and_whole_in_json(said: Said, told: Told):
    shown = said("show", "study.report")
    assert len(shown.splitlines()) < 40
    assert "rl_design_space.report.ClaimsLedger with title, notes, common, reading, later_reading, larger_s" in shown
    assert "…: shortened; --json shows the whole value" in shown
    assert "statement" in told("show", "study.report")["study=claims"]["default"]["claims"]["fig2-a"]
    assert "shortened" not in said("show", "exploration=linear")


def test_the_default_is_what_the_file_says_with_interpolations_as_they_are(told: Told):
    assert told("show", "tracking=sqlite")["parameters"]["tracking.uri"]["default"] == "sqlite:///${outputs}/mlflow.db"


def test_options_of_ones_own(told: Told, own: Path):
    near = told("show", "representation=near", "--config-dir", str(own))
    assert near["parameters"] == {
        "representation.radius": {
            "description": "cells within which it is.",
            "default": 3,
            "schema": {"type": "integer", "minimum": 1},
        }
    }
    child = told("show", "representation=child", "--config-dir", str(own))
    assert child["target"] == "rl_design_space.design.Direction"
    assert child["parameters"]["representation.rule"]["default"] == "horizontal_first"
    assert child["parameters"]["representation.goals"]["default"] == "remaining"
    opened = told("show", "representation=open", "--config-dir", str(own))
    assert opened["parameters"]["representation.radius"]["default"] == "???"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            "raises",
            "cannot be used: representation._target_=own_raises.Near: cannot be imported: RuntimeError: not today (",
        ),
        ("not_yaml", "cannot be used: not YAML: "),
        ("misspelt", "representation.ruel any x"),
        ("misspelt", "cannot be used: representation.ruel: no such key"),
    ],
)
def test_an_option_that_cannot_be_used_is_shown_with_the_reason(name: str, words: str, said: Said, own: Path):
    assert words in said("show", f"representation={name}", "--config-dir", str(own))


def test_a_study_is_shown_with_its_plan(said: Said):
    text = said("show", "study=table4")
    assert text.startswith("Table 4 (section 3.5): steps needed for 100 successes")
    assert "direction representation=direction exploration=linear exploration.k=0.02 world.size=10,20,30" in text
    assert "world.size 3 10 (6) 20 (6) 30 (6)" in text
    assert "= 18 points" in text
    assert "report: rl_design_space.report.PublishedTable" in text


def test_a_study_is_shown_as_it_would_run(told: Told):
    shown = told("show", "study=table4", "world.size=5", "~study.blocks.direction")
    assert shown["points"] == 3
    assert shown["axes"] == {"task.goals": {"1": 1, "2": 1, "3": 1}}
    assert list(shown["blocks"]) == ["ad_hoc"]


def test_a_study_with_constraints(said: Said, told: Told, own: Path):
    text = said("show", "study/mine", "--config-dir", str(own))
    assert "goes_round max(msa.lengths, default=1) > min(world.shape) the move goes all the way round" in text
    assert "5 combinations\n- 1 dropped by goes_round of mine: the move goes all the way round" in text
    shown = told("show", "study/mine", "--config-dir", str(own))
    counted = {key: shown[key] for key in ("points", "combinations", "duplicates", "includes", "report")}
    assert counted == {"points": 3, "combinations": 5, "duplicates": 1, "includes": [], "report": None}
    assert shown["dropped"][0]["count"] == 1


def test_a_study_with_readings(said: Said, own: Path):
    readings = "{fast: {learner.alpha: 0.2}, first: {learner.ties: first}, same: {learner.alpha: 0.1}}"
    variations = f"{{readings: {readings}, order: 2, around: [[first]]}}"
    (own / "study" / "varied.yaml").write_text(f"{{blocks: {{a: {{}}}}, variations: {variations}}}", encoding="utf-8")
    text = said("show", "study=varied", "--config-dir", str(own))
    assert "fast learner.alpha=0.2" in text
    assert "combined: alone and up to 2 together; first with each other one" in text
    assert "6 combinations\n- 2 duplicates of other points\n= 4 points" in text


def test_a_study_of_other_studies_and_one_without_points(said: Said, own: Path):
    assert "includes the points of table4, mine" in said("show", "study=both", "--config-dir", str(own))
    assert "no points: the report needs none" in said("show", "study=fig1")


def test_every_key_of_the_whole_configuration_is_explained(told: Told, planner):
    keys = set(planner.composer.config([])) - {"hydra", "study"}
    assert {"world", "seed", "tracking"} <= keys
    for key in keys:
        shown = told("show", key)
        entries = shown.get("options", shown)
        assert entries, key
        assert all(entry["description"] for entry in entries.values()), key


def test_keys_have_type_range_and_default(said: Said):
    assert "task.goals whole number at least 1 3 number of goals n, to be reached in order." in said("show", "task")
    assert "task.goals" not in said("show", "task.periods")
    assert "threads whole number or null 1 to 1024 null Number of learning threads; null for one a core." in said(
        "show", "threads"
    )
    assert "on_error one of continue, stop continue when a point fails" in said("show", "on_error")


def test_a_parameter_is_found_in_every_option_that_has_it(told: Told):
    shown = told("show", "exploration.start")
    options = ("error_driven", "exponential", "linear", "success_driven")
    assert list(shown) == [f"exploration={option}" for option in options]
    assert shown["exploration=linear"]["default"] == 0.9


def test_a_choice_is_listed(told: Told):
    assert list(told("show", "reward")["options"]) == ["each_success", "end_reward", "many_rewards", "shaped"]


def test_the_paths_of_the_schemas_are_shown(told: Told):
    shown = told("show", "schemas")
    assert shown[str(CONF / "world" / "schema.json")] == ["**/world/*.yaml"]
    assert [path for path in shown if not Path(path).is_file()] == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["exploration=linaer"], "exploration=linaer: no such option; did you mean exploration=linear?"),
        (["exploration/linaer"], "exploration=linaer: no such option; did you mean exploration=linear?"),
        (["exporation=linear"], "exporation: no such choice; did you mean exploration?"),
        (["study=tabel4"], "study=tabel4: no such option; did you mean study=table4?"),
        (["hydra/launcher=desing"], "hydra/launcher=desing: no such option; did you mean hydra/launcher=design?"),
        (["thread"], "thread: no such choice or key; did you mean threads?"),
        (["task.goal"], "task.goal: no such key; did you mean task.goals?"),
        (["exploration.kk"], "exploration.kk: no such key; did you mean exploration.k?"),
        (["seed.x"], "seed.x: no such key; did you mean seed?"),
        (["direction"], "direction: an option, not a choice; did you mean representation=direction?"),
        (["none"], "none: an option, not a choice; did you mean msa=none or curriculum=none or tracking=none?"),
        (["world="], "world=: no such choice or key; did you mean world?"),
        (["world=torus", "seed=1"], "seed=1: only studies accept overrides"),
        (["schemas", "seed=1"], "schemas: no such choice or key"),
        (["study=table4", "world.siz=5"], "study table4, block ad_hoc: world.siz: no such key in Torus"),
        (["study=table4", "twice"], "twice: not an override"),
    ],
)
def test_a_mistake_is_reported_with_a_correction(arguments: list[str], message: str):
    with pytest.raises(ConfigError) as raised:
        words.run("show", arguments)
    assert str(raised.value).startswith(message)
