"""Choices, options and studies as plain data, for `--json`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

from rl_design_space.catalogue.options import NOT_GIVEN, Choice, Option, Parameter
from rl_design_space.catalogue.studies import StudyEntry


def choice_record(choice: Choice) -> dict[str, Any]:
    """Return a choice with its options, without their parameters."""
    records = {option.name: option_record(option) for option in choice.options}
    for name, count in (choice.points or {}).items():
        records[name] |= {"points": count} if isinstance(count, int) else {"error": count}
    return {"description": choice.description, "default": choice.default, "options": records}


def option_record(option: Option) -> dict[str, Any]:
    """Return an option without its parameters."""
    named = {"description": option.summary, "file": option.place}
    return {**named, "error": option.error} if option.error else named


def whole_option_record(option: Option) -> dict[str, Any]:
    """Return an option with its parameters."""
    named = {"group": option.group, "option": option.name, **option_record(option), "target": option.target}
    return {**named, "description": option.description, "parameters": parameter_records(option.parameters)}


def parameter_records(parameters: Iterable[Parameter]) -> dict[str, Any]:
    """Return parameters by name."""
    return {each.name: _parameter_record(each) for each in parameters}


def study_record(study: StudyEntry) -> dict[str, Any]:
    """Return a study with the shape of its plan."""
    plan = study.plan
    return {
        "study": study.name,
        "description": study.description,
        "file": study.place,
        "blocks": study.blocks,
        "constraints": {name: {"drop": each.drop, "why": each.why} for name, each in study.constraints.items()},
        "includes": list(study.includes),
        "variations": asdict(study.variations) if study.variations else None,
        "report": study.report or None,
        "points": len(plan),
        "combinations": plan.combinations,
        "duplicates": plan.duplicates,
        "dropped": [asdict(dropped) for dropped in plan.dropped],
        "axes": plan.axes,
    }


def _parameter_record(parameter: Parameter) -> Mapping[str, Any]:
    given = {} if parameter.default is NOT_GIVEN else {"default": parameter.default}
    return {"description": parameter.description, **given, "schema": parameter.schema}
