"""The state of a page of runs in MLflow's UI, as a saved view has it.

A saved view is a tag `mlflow.sharedViewState.KEY` of an experiment. Its value is JSON: a name, the time of its
creation, and the state of the page, which is JSON in a string. The UI lists such views in a menu and opens one by its
address. MLflow does not document the state; this is how version 3.17.2 has it. A UI that does not understand it says so
and shows the page as it always does.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

State = dict[str, Any]

#: What an experiment's tag begins with whose value is a saved view; the rest is its key.
VIEW_TAG = "mlflow.sharedViewState."
#: The tag and its value that have an experiment shown among the trained models, not among the language models.
KIND = {"mlflow.experimentKind": "custom_model_development"}
#: Columns by the names that the UI has for them: the time of a run's start, which one sorts by, and its description.
STARTED, DESCRIPTION = "attributes.start_time", "attributes.`Description`"

_NAME, _CREATED, _DURATION = "attributes.`Run Name`", "runDateAndNestInfo", "duration"
#: Pixels of these columns, and of others: at least, for each letter of the heading, and beside it.
_WIDTHS = {_NAME: 190, _CREATED: 150, DESCRIPTION: 500}
_NARROWEST, _LETTER, _MARGIN = 80, 7, 20


def params(names: Iterable[str]) -> list[str]:
    """The columns of these parameters."""
    return [f"params.`{name}`" for name in names]


def metrics(names: Iterable[str]) -> list[str]:
    """The columns of these metrics."""
    return [f"metrics.`{name}`" for name in names]


def saved(name: str, state: State, created: int) -> str:
    """The JSON text of a view.

    Args:
        name: in the menu.
        state: of the page.
        created: milliseconds since 1970.
    """
    text = json.dumps(state, separators=(",", ":"))
    return json.dumps({"name": name, "createdAt": created, "updatedAt": created, "state": text})


def runs(condition: str, order: str, *, ascending: bool) -> State:
    """Which runs there are, in which order.

    Args:
        condition: in MLflow's search syntax; empty for all.
        order: a column.
        ascending: the least first.
    """
    return {
        "searchFilter": condition,
        "orderByKey": order,
        "orderByAsc": ascending,
        "startTime": "ALL",
        "lifecycleFilter": "Active",
        "modelVersionFilter": "All Runs",
        "datasetsFilter": [],
    }


def table(columns: Sequence[str]) -> State:
    """The columns after the run's name and creation, from left to right."""
    return {
        "selectedColumns": list(columns),
        "columnOrder": [_NAME, _CREATED, *columns, _DURATION],
        "columnWidths": {column: _width(column) for column in (_NAME, _CREATED, *columns)},
    }


def grouped(names: Sequence[str]) -> State:
    """Runs grouped by parameters; a chart shows the means of the groups."""
    keys = [{"mode": "param", "groupByData": name} for name in names]
    return {"groupBy": {"aggregateFunction": "average", "groupByKeys": keys}, "useGroupedValuesInCharts": True}


def visible(runs: Literal["all", "first 20"]) -> State:
    """Which of the runs are drawn."""
    return {"runsHiddenMode": {"all": "SHOW_ALL", "first 20": "FIRST_20_RUNS"}[runs]}


def charts(sections: Mapping[str, tuple[int, Sequence[State]]]) -> State:
    """The page of charts.

    Args:
        sections: by their titles how many charts stand side by side, and the charts.
    """
    return {
        "compareRunSections": [_section(title, columns) for title, (columns, _) in sections.items()],
        "compareRunCharts": [
            {**chart, "metricSectionId": title} for title, (_, cards) in sections.items() for chart in cards
        ],
        # Else the UI puts the sections into an order of its own.
        "isAccordionReordered": True,
        "hideEmptyCharts": True,
    }


def lines(metric: str, *, logarithmic: bool) -> State:
    """A chart of a metric over its steps, a line a run or group."""
    return {
        **_chart("LINE", metric),
        "metricKey": metric,
        "scaleType": "log" if logarithmic else "linear",
        "xAxisKey": "step",
        "xAxisScaleType": "linear",
        "yAxisKey": "metric",
        "yAxisExpressions": [],
        "range": {},
        "lineSmoothness": 0,
        "displayPoints": False,
        "ignoreOutliers": False,
        "selectedXAxisMetricKey": "",
        "useGlobalXaxisKey": True,
        "useGlobalLineSmoothing": True,
    }


def bars(metric: str) -> State:
    """A chart of a metric's last value, a bar a run or group."""
    return {**_chart("BAR", metric), "metricKey": metric}


def no_bars(metric: str) -> State:
    """No chart of a metric: the UI adds one of each that has none, unless the one it had was deleted."""
    return {**bars(metric), "deleted": True, "isGenerated": True}


def parallel_coordinates(names: Sequence[str], metric: str) -> State:
    """A line a run through its parameters to a metric; runs that lack one of them are left out."""
    chosen = {"selectedParams": list(names), "selectedMetrics": [metric], "showAllRuns": True}
    return {**_chart("PARALLEL", f"parallel {metric}"), **chosen}


def _chart(kind: str, name: str) -> State:
    own = {"type": kind, "uuid": name, "displayName": name}
    return {**own, "deleted": False, "isGenerated": False, "runsCountToCompare": 20}


def _section(title: str, columns: int) -> State:
    own = {"uuid": title, "name": title, "columns": columns, "cardHeight": 400}
    return {**own, "display": True, "isReordered": True, "deleted": False, "isGenerated": False}


def _width(column: str) -> int:
    """Pixels in which a column's heading can be read."""
    heading = column.partition("`")[2]
    return _WIDTHS.get(column) or max(_NARROWEST, _LETTER * len(heading) + _MARGIN)
