"""What a study's points, all points and all sweeps are looked at with in MLflow's UI: columns, order, charts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING
from urllib.parse import urlencode

from rl_design_space.learning.measures import CURVES, SCALARS
from rl_design_space.tracking import view_state as ui
from rl_design_space.tracking.record import STUDY_TAG
from rl_design_space.tracking.view_state import State

if TYPE_CHECKING:
    from rl_design_space.plan.plan import Plan

#: The axes of a plan: by the name of a parameter how many points have each of its values, see `Plan.axes`.
Axes = Mapping[str, Mapping[str, int]]

#: The key of the view of all points, of all sweeps, and what the keys of the studies' views begin with.
POINTS_KEY, SWEEPS_KEY, STUDY_KEY = "points", "sweeps", "study."

#: The scalars that are shown; points are sorted by the first.
_SHOWN = ("total_steps", "failed_trials", "final_steps_over_optimum")
#: The parameter that tells a quick look, which is of the same study, from the study.
_PERIODS = "task.periods"
#: The parameters in which points of different studies differ.
_USUAL = ("representation", "exploration", "msa", "reward", "world", "world.size", "task.goals", _PERIODS)
_SWEEP_COUNTS = ("points/done", "points/already", "points/failed", "points/elsewhere", "points/left")
#: Runs up to which each has a line of its own, and which the UI loads at once.
_LINES, _PAGE = 20, 100
#: Groups whose colours can be told apart, and axes of parallel coordinates, at most.
_GROUPS, _PARALLEL = 12, 6


def study_view(study: str, axes: Axes, created: int) -> tuple[str, str]:
    """The view of a study's points, the least total steps first.

    Its table shows the parameters in which the points differ. Up to 20 points are drawn as a line each. Up to 100, as
    many as the UI loads at once, are grouped by the parameters that divide them most evenly, and lines are means of
    groups. Of more than that the first 20 are drawn: the mean of those loaded is not the mean of a group.

    Args:
        study: its name.
        axes: the parameters in which its points differ.
        created: milliseconds since 1970.

    Returns:
        The key of the view, and its JSON text.
    """
    count = _points(axes)
    shown = [*axes, *({_PERIODS} - axes.keys())]
    groups = _telling(axes) if _LINES < count <= _PAGE else []
    state = {
        **ui.runs(f"tags.`{STUDY_TAG}{study}` = 'true'", *ui.metrics(_SHOWN[:1]), ascending=True),
        **ui.table([*ui.params(shown), *ui.metrics(_SHOWN)]),
        # The UI cannot draw parallel coordinates of groups.
        **_charts([] if groups else _parallel(axes)),
        **(ui.grouped(groups) if groups else {}),
        **ui.visible("all" if groups or count <= _LINES else "first 20"),
    }
    return f"{STUDY_KEY}{study}", ui.saved(study, state, created)


def points_tags(plan: Plan, created: int) -> dict[str, str]:
    """The tags that a plan gives the experiment of design points: a view of each of its studies, and of all points.

    Args:
        plan: or a shard of it.
        created: milliseconds since 1970.
    """
    views = [points_view(created)]
    # All shards are alike: their points were dealt out in turn.
    shards = round(plan.whole / len(plan)) if len(plan) else 1
    for study in plan.studies:
        its_own = replace(plan, points=[planned for planned in plan if study in planned.studies])
        axes = {
            name: {value: count * shards for value, count in counts.items()} for name, counts in its_own.axes.items()
        }
        views.append(study_view(study, axes, created))
    return {**ui.KIND, **{f"{ui.VIEW_TAG}{key}": text for key, text in views}}


def sweeps_tags(created: int) -> dict[str, str]:
    """The tags of the experiment of sweeps: the view of all of them.

    Args:
        created: milliseconds since 1970.
    """
    key, text = sweeps_view(created)
    return {**ui.KIND, f"{ui.VIEW_TAG}{key}": text}


def points_view(created: int) -> tuple[str, str]:
    """The view of all design points, the latest first.

    Args:
        created: milliseconds since 1970.

    Returns:
        The key of the view, and its JSON text.
    """
    state = {
        **ui.runs("", ui.STARTED, ascending=False),
        **ui.table([*ui.params(_USUAL), *ui.metrics(_SHOWN)]),
        **_charts([]),
        **ui.visible("first 20"),
    }
    return POINTS_KEY, ui.saved("all design points", state, created)


def sweeps_view(created: int) -> tuple[str, str]:
    """The view of the summary runs of all sweeps, the latest first.

    Args:
        created: milliseconds since 1970.

    Returns:
        The key of the view, and its JSON text.
    """
    table = ui.table([ui.DESCRIPTION, *ui.metrics(_SWEEP_COUNTS)])
    return SWEEPS_KEY, ui.saved("all sweeps", {**ui.runs("", ui.STARTED, ascending=False), **table}, created)


def link(address: str, experiment: str, key: str = "", *, charts: bool = False) -> str:
    """The address of an experiment's runs in the UI.

    Args:
        address: of the server, e.g. http://127.0.0.1:5000.
        experiment: its id.
        key: of a saved view.
        charts: whether to open the charts instead of the table.
    """
    query = {"viewStateShareKey": key} if key else {}
    if charts:
        query["compareRunsMode"] = "CHART"
    # Else the side bar is for work on language models.
    query["workflowType"] = "machine_learning"
    return f"{address.rstrip('/')}/#/experiments/{experiment}/runs?{urlencode(query)}"


def _charts(parallel: Sequence[str]) -> State:
    """Learning curves, bars of the scalars, and parallel coordinates of some parameters."""
    # Steps fall by powers of ten, success rates do not.
    curves = [ui.lines(curve, logarithmic=curve.startswith("steps/")) for curve in CURVES]
    totals = [ui.bars(scalar) for scalar in _SHOWN]
    others = [ui.no_bars(scalar) for scalar in SCALARS if scalar not in _SHOWN]
    sections: dict[str, tuple[int, Sequence[State]]] = {
        "Learning curves": (3, curves),
        "Totals": (3, [*totals, *others]),
    }
    if parallel:
        sections["Choices"] = (1, [ui.parallel_coordinates(parallel, _SHOWN[0])])
    return ui.charts(sections)


def _points(axes: Axes) -> int:
    return max((sum(counts.values()) for counts in axes.values()), default=1)


def _telling(axes: Axes) -> list[str]:
    """The parameters to group by: those that divide the points most evenly, into few groups; options before values."""
    chosen: list[str] = []
    groups = 1
    for name in sorted(_complete(axes), key=lambda name: ("." in name, -_entropy(axes[name]))):
        # The values of an option that tells the points apart tell nothing new.
        if groups * len(axes[name]) <= _GROUPS and name.partition(".")[0] not in chosen:
            chosen.append(name)
            groups *= len(axes[name])
    return [name for name in axes if name in chosen]


def _parallel(axes: Axes) -> list[str]:
    """The parameters for parallel coordinates: of those that every point has the ones that divide them most evenly."""
    best = sorted(_complete(axes), key=lambda name: -_entropy(axes[name]))[:_PARALLEL]
    return [name for name in axes if name in best]


def _complete(axes: Axes) -> list[str]:
    """The parameters that every point has."""
    return [name for name, counts in axes.items() if sum(counts.values()) == _points(axes)]


def _entropy(counts: Mapping[str, int]) -> float:
    """In bits: how much a parameter tells about which point it is."""
    total = sum(counts.values())
    return -sum(count / total * math.log2(count / total) for count in counts.values())
