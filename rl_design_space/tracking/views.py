"""Saved views for MLflow's UI: columns, order and charts of a study, of all points, and of all sweeps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING
from urllib.parse import urlencode

from rl_design_space.design import stages_of
from rl_design_space.learning.measures import CURVES, SCALARS
from rl_design_space.learning.stage_record import STAGE_CURVE
from rl_design_space.tracking import view_state as ui
from rl_design_space.tracking.tags import STUDY_TAG
from rl_design_space.tracking.view_state import State

if TYPE_CHECKING:
    from rl_design_space.plan.plan import Plan

#: Axes of a plan: by parameter name and value the number of points, see `Plan.axes`.
Axes = Mapping[str, Mapping[str, int]]

#: Keys of the views of all points and of all sweeps, and prefix of the keys of the views of studies.
POINTS_KEY, SWEEPS_KEY, STUDY_KEY = "points", "sweeps", "study."

#: Scalars that are shown; points are sorted by the first.
_SHOWN = ("total_steps", "failed_trials", "final_steps_over_optimum")
#: Parameter in which a quick run of a study differs from the study itself.
_PERIODS = "task.periods"
#: Parameters in which points of different studies differ.
_USUAL = ("representation", "exploration", "msa", "reward", "world", "world.size", "task.goals", _PERIODS)
_SWEEP_COUNTS = ("points/done", "points/already", "points/failed", "points/elsewhere", "points/left")
#: Maximum number of runs that are drawn as a line each, and number of runs that the UI loads at once.
_LINES, _PAGE = 20, 100
#: Maximum number of groups, whose colours can be told apart, and of axes of parallel coordinates.
_GROUPS, _PARALLEL = 12, 6


def study_view(study: str, axes: Axes, created: int, *, stages: bool = False) -> tuple[str, str]:
    """Return the view of a study's points, the fewest total steps first.

    Its table shows the parameters in which the points differ. Up to 20 points are drawn as a line each. Up to 100, as
    many as the UI loads at once, are grouped by the parameters that divide them most evenly, and lines are means of
    groups. Of more points the first 20 are drawn: the mean of the loaded ones would not be the mean of a group.

    Args:
        study: name of the study.
        axes: the parameters in which its points differ.
        created: milliseconds since 1970.
        stages: whether periods of some of its points have several stages.

    Returns:
        The key of the view, and its JSON text.
    """
    count = _points(axes)
    shown = [*axes, *({_PERIODS} - axes.keys())]
    groups = _grouping(axes) if _LINES < count <= _PAGE else []
    state = {
        **ui.run_list(f"tags.`{STUDY_TAG}{study}` = 'true'", *ui.metrics(_SHOWN[:1]), ascending=True),
        **ui.table_columns([*ui.params(shown), *ui.metrics(_SHOWN)]),
        # The UI cannot draw parallel coordinates of groups.
        **_charts([] if groups else _parallel(axes), (*CURVES, STAGE_CURVE) if stages else CURVES),
        **(ui.grouped(groups) if groups else {}),
        **ui.visible("all" if groups or count <= _LINES else "first 20"),
    }
    return f"{STUDY_KEY}{study}", ui.saved_view(study, state, created)


def points_tags(plan: Plan, created: int) -> dict[str, str]:
    """Return the tags of the experiment of design points: a view of each study of a plan, and one of all points.

    Args:
        plan: a plan or a shard of one.
        created: milliseconds since 1970.
    """
    views = [points_view(created)]
    # All shards are alike, because points are assigned to them in turn.
    shards = round(plan.whole / len(plan)) if len(plan) else 1
    for study in plan.studies:
        of_study = replace(plan, points=[planned for planned in plan if study in planned.studies])
        axes = {
            name: {value: count * shards for value, count in counts.items()} for name, counts in of_study.axes.items()
        }
        stages = any(stages_of(planned.point) for planned in of_study)
        views.append(study_view(study, axes, created, stages=stages))
    return {**ui.KIND, **{f"{ui.VIEW_TAG}{key}": text for key, text in views}}


def sweeps_tags(created: int) -> dict[str, str]:
    """Return the tags of the experiment of sweeps: a view of all sweeps.

    Args:
        created: milliseconds since 1970.
    """
    key, text = sweeps_view(created)
    return {**ui.KIND, f"{ui.VIEW_TAG}{key}": text}


def points_view(created: int) -> tuple[str, str]:
    """Return the view of all design points, the latest first.

    Args:
        created: milliseconds since 1970.

    Returns:
        The key of the view, and its JSON text.
    """
    state = {
        **ui.run_list("", ui.STARTED, ascending=False),
        **ui.table_columns([*ui.params(_USUAL), *ui.metrics(_SHOWN)]),
        # The UI hides the chart of the stages while no run that is shown has any.
        **_charts([], (*CURVES, STAGE_CURVE)),
        **ui.visible("first 20"),
    }
    return POINTS_KEY, ui.saved_view("all design points", state, created)


def sweeps_view(created: int) -> tuple[str, str]:
    """Return the view of the summary runs of all sweeps, the latest first.

    Args:
        created: milliseconds since 1970.

    Returns:
        The key of the view, and its JSON text.
    """
    table = ui.table_columns([ui.DESCRIPTION, *ui.metrics(_SWEEP_COUNTS)])
    return SWEEPS_KEY, ui.saved_view("all sweeps", {**ui.run_list("", ui.STARTED, ascending=False), **table}, created)


def link(address: str, experiment: str, key: str = "", *, charts: bool = False) -> str:
    """Return the address of an experiment's runs in the UI.

    Args:
        address: of the server, e.g. http://127.0.0.1:5000.
        experiment: id of the experiment.
        key: of a saved view.
        charts: whether to open the charts instead of the table.
    """
    query = {"viewStateShareKey": key} if key else {}
    if charts:
        query["compareRunsMode"] = "CHART"
    # Otherwise the side bar shows entries for language models.
    query["workflowType"] = "machine_learning"
    return f"{address.rstrip('/')}/#/experiments/{experiment}/runs?{urlencode(query)}"


def _charts(parallel: Sequence[str], names: Sequence[str] = CURVES) -> State:
    """Return charts: learning curves, bars of the scalars, and parallel coordinates of some parameters."""
    # Steps fall by powers of ten, success rates do not.
    curves = [ui.lines(curve, logarithmic=curve.startswith("steps/")) for curve in names]
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


def _grouping(axes: Axes) -> list[str]:
    """Return the parameters to group by: those that divide the points most evenly into few groups, options first."""
    chosen: list[str] = []
    groups = 1
    for name in sorted(_complete(axes), key=lambda name: ("." in name, -_entropy(axes[name]))):
        # Once points are grouped by an option, its values add nothing.
        if groups * len(axes[name]) <= _GROUPS and name.partition(".")[0] not in chosen:
            chosen.append(name)
            groups *= len(axes[name])
    return [name for name in axes if name in chosen]


def _parallel(axes: Axes) -> list[str]:
    """Return the parameters for parallel coordinates: of those that all points have, the most evenly dividing ones."""
    best = sorted(_complete(axes), key=lambda name: -_entropy(axes[name]))[:_PARALLEL]
    return [name for name in axes if name in best]


def _complete(axes: Axes) -> list[str]:
    """Return the parameters that all points have."""
    return [name for name, counts in axes.items() if sum(counts.values()) == _points(axes)]


def _entropy(counts: Mapping[str, int]) -> float:
    """Return the entropy in bits of the values of a parameter among the points."""
    total = sum(counts.values())
    return -sum(count / total * math.log2(count / total) for count in counts.values())
