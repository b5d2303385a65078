"""Descriptions of studies and their points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rl_design_space.catalogue.comments import leading_comment
from rl_design_space.catalogue.options import in_words
from rl_design_space.catalogue.search import Search
from rl_design_space.config.build import plain
from rl_design_space.plan.constraint import Constraint, constraints_of
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import load_study
from rl_design_space.plan.variations import Variations, variations_of


@dataclass(frozen=True)
class StudyEntry:
    """A study, described by its file.

    Attributes:
        name: name of the study.
        description: leading comment of its file.
        place: path of its file.
        blocks: the sweeps of each block, by key.
        constraints: its constraints, by name.
        includes: other studies whose points belong to this one.
        variations: the readings that change its points; None if there are none.
        report: `_target_` of its report; empty if it has none.
        plan: its points.
    """

    name: str
    description: str
    place: str
    blocks: Mapping[str, Mapping[str, Any]]
    constraints: Mapping[str, Constraint]
    includes: Sequence[str]
    variations: Variations | None
    report: str
    plan: Plan


def study(search: Search, planner: Planner, name: str, overrides: Sequence[str] = ()) -> StudyEntry:
    """Return the description of a study.

    Args:
        search: where to find its file.
        planner: plans its points.
        name: name of the study.
        overrides: overrides of the command line, as for running it.

    Raises:
        ConfigError: the study does not exist, or cannot be planned.
    """
    search.check("study", name)
    loaded = load_study(name, overrides, planner)
    node = plain(loaded.config, "study")
    report = node.get("report")
    return StudyEntry(
        name,
        leading_comment(search.text(f"study/{name}")),
        search.place(f"study/{name}"),
        node.get("blocks") or {},
        constraints_of(node.get("constraints")),
        node.get("includes") or (),
        variations_of(node.get("variations")),
        str(report.get("_target_", "")) if isinstance(report, Mapping) else "",
        loaded.plan,
    )


def count_points(planner: Planner, name: str) -> int | str:
    """Return the number of points of a study, or why it cannot be planned."""
    try:
        return len(load_study(name, (), planner).plan)
    except Exception as problem:  # a study of the user may fail in any way
        return in_words(problem)
