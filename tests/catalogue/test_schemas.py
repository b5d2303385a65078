"""The schemas for editors are up to date, accept every shipped file, and point at mistakes."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml
from jsonschema import Draft7Validator

from rl_design_space._paths import CONF
from rl_design_space.catalogue.schemas import generated, schema_files

FILES = sorted(CONF.rglob("*.yaml"))
MODELINE = re.compile(r"^# yaml-language-server: \$schema=(\S+)$", re.MULTILINE)

OWN_FILE = """
# @package _group_
_target_: mine.Near
radius: 3
"""


@cache
def validator(schema: Path) -> Draft7Validator:
    return Draft7Validator(json.loads(schema.read_text(encoding="utf-8")))


def problems(text: str, group: str) -> dict[str, str]:
    """Return the messages that an editor would show, by dotted path."""
    found = validator(CONF / group / "schema.json").iter_errors(_as_editors_see(yaml.safe_load(text)))
    said: dict[str, str] = {}
    for error in found:
        place = ".".join(map(str, error.absolute_path))
        said[place] = f"{said.get(place, '')}{error.message}; "
    return said


def _as_editors_see(value: Any) -> Any:
    """Return the content with all keys as text, as editors read them."""
    if isinstance(value, dict):
        return {str(key): _as_editors_see(inner) for key, inner in value.items()}
    return [_as_editors_see(inner) for inner in value] if isinstance(value, list) else value


def name_of(file: Path) -> str:
    return str(file.relative_to(CONF))


def test_the_files_are_up_to_date():
    files = {path.relative_to(CONF).as_posix(): path.read_text(encoding="utf-8") for path in CONF.rglob("*.json")}
    assert files == generated(), "renew them: make schemas"


@pytest.mark.parametrize("schema", sorted(CONF.rglob("schema.json")), ids=name_of)
def test_a_schema_is_valid(schema: Path):
    Draft7Validator.check_schema(json.loads(schema.read_text(encoding="utf-8")))


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_shipped_file_names_its_schema_and_conforms_to_it(file: Path):
    text = file.read_text(encoding="utf-8")
    (named,) = MODELINE.findall(text)
    assert (file.parent / named).resolve() == file.parent / "schema.json"
    assert problems(text, name_of(file.parent)) == {}


@pytest.mark.parametrize(
    ("group", "text"),
    [
        ("exploration", "{_target_: rl_design_space.design.Linear, k: '???', start: '${oc.env:START}'}"),
        ("exploration", "{_target_: rl_design_space.design.exploration.Linear, k: 1}"),
        ("exploration", "{defaults: [linear, _self_], k: 0.05}"),
        ("exploration", "{_target_: '${my.target}', steps: [1, 2]}"),
        ("representation", OWN_FILE),
        ("world", "{_target_: rl_design_space.design.Torus, size: [10, 20]}"),
        ("world", "{_target_: rl_design_space.design.Torus, size: ['${a}', 20]}"),
        ("tracking", "{defaults: [sqlite], uri: 'http://localhost:5000'}"),
        ("study", "{includes: [table3, mine]}"),
        ("study", "blocks: {a: {world: torus, world.size: '10,20', +representation.radius: 2, ~task.goals: 3}}"),
        (
            "study",
            "{blocks: {a: {seed: 'range(0,5)', msa.lengths: [2, 3]}}, constraints: {odd: {drop: 'True', why: so}}}",
        ),
        ("study", "blocks: {a: {representation: [ad_hoc, direction], seed: [0, 1], msa.lengths: [[], [2, 3]]}}"),
        ("study", "{report: {_target_: mine.Report, anything: 1}}"),
        (
            "study",
            "{includes: [a], variations: {readings: {b: {learner.alpha: 0.5}}, around: [[b]], values: {seed: 1}}}",
        ),
        ("study", "{defaults: [mine], variations: {order: 2}, report: {title: of two}}"),
        ("", "{defaults: [{world: torus}, _self_], seed: 1, threads: 2, exploration: {k: 0.1}}"),
    ],
)
def test_files_that_hydra_accepts_are_valid(group: str, text: str):
    assert problems(text, group) == {}


@pytest.mark.parametrize(
    ("group", "text", "place", "says"),
    [
        # A misspelt key.
        ("exploration", "{_target_: rl_design_space.design.Linear, kk: 0.1}", "", "'kk' was unexpected"),
        ("study", "{block: {a: {world: torus}}}", "", "'block' was unexpected"),
        ("study", "blocks: {a: {explorations: linear}}", "blocks.a", "'explorations' does not match"),
        (
            "study",
            "{includes: [a], constraints: {odd: {drops: x, why: y}}}",
            "constraints.odd",
            "'drops' was unexpected",
        ),
        ("", "{sed: 1}", "", "'sed' was unexpected"),
        ("", "{task: {_target_: rl_design_space.design.Task, goal: 2}}", "task", "'goal' was unexpected"),
        # A value outside its range.
        ("exploration", "{_target_: rl_design_space.design.Linear, start: 1.5}", "start", "1.5 is not valid"),
        ("world", "{_target_: rl_design_space.design.Walled, size: [10, 1]}", "size", "[10, 1] is not valid"),
        (
            "msa",
            "{_target_: rl_design_space.design.MultiStepActions, lengths: [2, 1]}",
            "lengths",
            "[2, 1] is not valid",
        ),
        ("learner", "{_target_: rl_design_space.design.QLearning, ties: last}", "ties", "'last' is not valid"),
        ("study", "blocks: {a: {exploration.epsilon: 2}}", "blocks.a.exploration.epsilon", "2 is not valid"),
        ("", "{task: {_target_: rl_design_space.design.Task, goals: 0}}", "task.goals", "0 is not valid"),
        ("", "{on_error: wait}", "on_error", "'wait' is not valid"),
        # A value of another type.
        ("exploration", "{_target_: rl_design_space.design.Linear, k: fast}", "k", "'fast' is not valid"),
        (
            "hydra/launcher",
            "{_target_: hydra_plugins.rl_design_space.launcher.DesignLauncher, dumps: 1}",
            "dumps",
            "1 is",
        ),
        ("study", "{includes: [a], variations: {order: 2}}", "variations", "'readings' is a required property"),
        ("study", "{report: {title: a}}", "report", "'_target_' is a required property"),
        (
            "study",
            "{report: {_target_: rl_design_space.report.StateSpace}}",
            "report",
            "'title' is a required property",
        ),
        ("study", "blocks: [a, b]", "blocks", "is not of type 'object'"),
        (
            "study",
            "{includes: [a], variations: {readings: {b: {learner.alpha: 5}}}}",
            "variations.readings.b.learner.alpha",
            "5 is not valid",
        ),
        ("", "{seed: '1'}", "seed", "'1' is not valid"),
        # A class that does not exist, or no class.
        ("exploration", "{_target_: rl_design_space.design.Linaer}", "_target_", "Linaer' is not valid"),
        ("exploration", "{k: 0.1}", "", "'_target_' is a required property"),
        ("tracking", "{_target_: rl_design_space.tracking.MlflowTracking}", "", "'uri' is a required property"),
    ],
)
def test_a_mistake_is_reported_at_its_place(group: str, text: str, place: str, says: str):
    found = problems(text, group)
    assert list(found) == [place]
    assert says in found[place]


def test_every_field_of_a_component_has_a_description():
    explained = 0
    for schema in CONF.rglob("schema.json"):
        for rule in json.loads(schema.read_text(encoding="utf-8")).get("allOf", []):
            fields = rule["then"].get("properties", {})
            unexplained = {name for name, field in fields.items() if "description" not in field}
            assert unexplained <= {"_target_", "defaults"}, schema
            explained += len(fields) - len(unexplained)
    assert explained > 20


def test_every_group_with_options_has_a_schema():
    folders = {file.parent for file in FILES}
    assert {path.parent for path in schema_files().values()} == folders
