"""Every file under conf/ composes and builds; new files are covered automatically."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from pkgutil import resolve_name

import pytest
import yaml

from rl_design_space._paths import CONF
from rl_design_space.catalogue.comments import first_sentence, leading_comment
from rl_design_space.config.build import build_component, plain
from rl_design_space.design import DesignPoint
from rl_design_space.plan.planner import Planner
from rl_design_space.run.settings import build_settings
from tests.design.options import overrides_of
from tests.points import shipped_study

FILES = sorted(CONF.rglob("*.yaml"))
STUDIES = [file.stem for file in FILES if file.parent.name == "study"]
OPTIONS = [file for file in FILES if file.parent != CONF and not {"study", "hydra"} & set(file.relative_to(CONF).parts)]
STUDIES_WITH_REPORT = [
    name for name in STUDIES if "report" in yaml.safe_load((CONF / f"study/{name}.yaml").read_text())
]


def name_of(file: Path) -> str:
    return str(file.relative_to(CONF))


def test_the_parameters_of_this_file_are_not_empty():
    assert OPTIONS
    assert STUDIES
    assert STUDIES_WITH_REPORT


@pytest.mark.parametrize("file", FILES, ids=name_of)
def test_a_file_begins_with_a_description(file: Path):
    assert len(first_sentence(leading_comment(file.read_text(encoding="utf-8")))) > 5


@pytest.mark.parametrize("file", OPTIONS, ids=name_of)
def test_an_option_composes_and_builds(file: Path, planner: Planner):
    group = file.parent.name
    config = planner.composer.config([f"{group}={file.stem}"])
    built = build_component(config, group)
    assert type(built) is resolve_name(config[group]._target_)
    if group in {field.name for field in fields(DesignPoint)}:
        assert getattr(planner(overrides_of(group, file.stem)).point, group) == built
    else:
        assert getattr(build_settings(config), group) == built


@pytest.mark.parametrize("file", OPTIONS, ids=name_of)
def test_every_value_of_an_option_can_be_overridden_without_a_plus(file: Path, planner: Planner):
    config = planner.composer.config([f"{file.parent.name}={file.stem}"])
    node = plain(config, file.parent.name)
    assert set(node) == {"_target_", *(field.name for field in fields(resolve_name(node["_target_"])))}


def test_every_value_of_a_point_can_be_overridden_without_a_plus(planner: Planner):
    config = planner.composer.config([])
    assert {field.name for field in fields(DesignPoint)} <= set(config)
    assert set(plain(config, "task")) == {"_target_", *(field.name for field in fields(DesignPoint().task))}


def test_the_shipped_default_is_the_default_in_python(planner: Planner):
    assert planner([]).point == DesignPoint()


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_has_points_and_all_of_them_build(name: str):
    study = shipped_study(name)
    # A study has points, its own or those of other studies, or a report without points.
    assert bool(study.plan) == ("blocks" in study.config.study or "includes" in study.config.study)
    assert study.plan or study.report()
    assert len({planned.fingerprint for planned in study.plan}) == len(study.plan)
    assert all(planned.studies[0] == name for planned in study.plan)


@pytest.mark.parametrize("name", STUDIES_WITH_REPORT)
def test_the_report_of_a_study_builds(name: str):
    study = shipped_study(name)
    report = study.report()
    described = study.config.study.report
    assert type(report) is resolve_name(described._target_)
    assert getattr(report, "title", None) == described.get("title")  # several figures have one each
