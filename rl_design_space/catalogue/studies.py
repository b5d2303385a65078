"""What a study is about, and which points it has."""

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


@dataclass(frozen=True)
class StudyEntry:
    """A study as its file describes it.

    Attributes:
        name: of the study.
        description: the leading comment of its file.
        place: where its file lies.
        blocks: the sweeps of each block, by key.
        constraints: by name.
        includes: other studies whose points are this one's.
        report: `_target_` of its report; empty if it has none.
        plan: its points.
    """

    name: str
    description: str
    place: str
    blocks: Mapping[str, Mapping[str, Any]]
    constraints: Mapping[str, Constraint]
    includes: Sequence[str]
    report: str
    plan: Plan


def study(search: Search, planner: Planner, name: str, overrides: Sequence[str] = ()) -> StudyEntry:
    """Describe a study.

    Args:
        search: finds its file.
        planner: plans its points.
        name: of the study.
        overrides: of the command line, as they would be given to run it.

    Raises:
        ConfigError: there is no such study, or it cannot be planned.
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
        str(report.get("_target_", "")) if isinstance(report, Mapping) else "",
        loaded.plan,
    )


def count_points(planner: Planner, name: str) -> int | str:
    """How many points a study has, or why it cannot be planned."""
    try:
        return len(load_study(name, (), planner).plan)
    except Exception as problem:  # a study of a user's own may be wrong in any way
        return in_words(problem)
