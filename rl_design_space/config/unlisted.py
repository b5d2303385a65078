"""Values that the parameters of a point leave out: fields that a component got later, see `design.identity`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from functools import cache
from typing import Any

import yaml

from rl_design_space._paths import CONF
from rl_design_space.config.overrides import OPTION_GROUPS
from rl_design_space.config.target import imported
from rl_design_space.design import Task
from rl_design_space.design.identity import ABSENT_AS, is_listed, is_shipped_name


def left_out(parameters: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    """Return those of the named values that the parameters of a point leave out because they are the default.

    Args:
        parameters: of the point, by dotted name; an option by its name.
        names: dotted names, such as `curriculum.zero_shot`.
    """
    found: dict[str, Any] = {}
    for name in names:
        choice, _, field = name.partition(".")
        # An option of the user's own that replaces a shipped one may be of another class.
        if name in parameters or not field or f"{choice}.source" in parameters:
            continue
        defaults = _defaults(choice, str(parameters.get(choice, "")))
        if field in defaults:
            found[name] = defaults[field]
    return found


def named_defaults(points: Iterable[Mapping[str, Any]], asked: Sequence[str] = ()) -> list[str]:
    """Return the names of values that some points leave out, and that others list or that somewhere are asked for.

    Args:
        points: parameters of each point.
        asked: texts in which names may stand, such as the arguments of a command.
    """
    points = list(points)
    options = {(choice, str(each[choice])) for each in points for choice in OPTION_GROUPS if choice in each}
    options.add(("task", ""))
    unlisted = {f"{choice}.{field}" for choice, option in options for field in _defaults(choice, option)}
    listed = {name for name in unlisted if any(name in each for each in points)}
    return sorted(listed | {name for name in unlisted if any(name in text for text in asked)})


@cache
def _defaults(choice: str, option: str) -> Mapping[str, Any]:
    """Return the values of a shipped option that parameters leave out, by the name of the field."""
    kind = Task if choice == "task" else _class_of(choice, option)
    unlisted = [field for field in fields(kind) if ABSENT_AS in field.metadata] if kind else []
    values = {field: field.metadata[ABSENT_AS] for field in unlisted}
    return {field.name: value for field, value in values.items() if not is_listed(field, value)}


def _class_of(choice: str, option: str) -> Any:
    """Return the class of a shipped option; None if there is none."""
    file = CONF / choice / f"{option}.yaml"
    if choice not in OPTION_GROUPS or "/" in option or not file.is_file():
        return None
    target = yaml.safe_load(file.read_text(encoding="utf-8"))["_target_"]
    return imported(f"{choice}._target_", target) if is_shipped_name(target) else None
