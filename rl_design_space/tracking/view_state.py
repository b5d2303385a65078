"""The state of a page of runs in MLflow's UI, as saved views store it.

A saved view is a tag `mlflow.sharedViewState.KEY` of an experiment. Its value is JSON: a name, the time of its
creation, and the state of the page, which is JSON in a string. The UI lists such views in a menu and opens one by its
address. MLflow does not document the state; this is the format of version 3.17.2. A UI that cannot read it reports that
and shows the default page.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

State = dict[str, Any]

#: Prefix of the tags of an experiment that hold saved views; the rest of the name is the key of the view.
VIEW_TAG = "mlflow.sharedViewState."
#: Tag by which the UI lists an experiment under model training, not under language models.
KIND = {"mlflow.experimentKind": "custom_model_development"}
#: Column names of the UI: start time of a run, for sorting, and its description.
STARTED, DESCRIPTION = "attributes.start_time", "attributes.`Description`"

_NAME, _CREATED, _DURATION = "attributes.`Run Name`", "runDateAndNestInfo", "duration"
#: Width of these columns in pixels; of all others the minimum, the width of a letter of the heading, and the margin.
_WIDTHS = {_NAME: 280, _CREATED: 150, DESCRIPTION: 500}
_NARROWEST, _LETTER, _MARGIN = 80, 7, 20


def params(names: Iterable[str]) -> list[str]:
    """Return the columns of parameters."""
    return [f"params.`{name}`" for name in names]


def metrics(names: Iterable[str]) -> list[str]:
    """Return the columns of metrics."""
    return [f"metrics.`{name}`" for name in names]


def saved_view(name: str, state: State, created: int) -> str:
    """Return the JSON text of a view.

    Args:
        name: title in the menu.
        state: of the page.
        created: milliseconds since 1970.
    """
    text = json.dumps(state, separators=(",", ":"))
    return json.dumps({"name": name, "createdAt": created, "updatedAt": created, "state": text})


def created_at(text: str) -> int:
    """Return when a view was saved, in milliseconds since 1970; 0 if its text does not say so."""
    try:
        return int(json.loads(text)["createdAt"])
    except (ValueError, TypeError, LookupError):  # another version of MLflow, or a user, has written it
        return 0


def run_list(condition: str, order: str, *, ascending: bool) -> State:
    """Return the selection and order of the runs.

    Args:
        condition: filter of MLflow's search; empty for all runs.
        order: column to sort by.
        ascending: whether the smallest value comes first.
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


def table_columns(columns: Sequence[str]) -> State:
    """Return the columns of the table after the run's name and creation time, from left to right."""
    return {
        "selectedColumns": list(columns),
        "columnOrder": [_NAME, _CREATED, *columns, _DURATION],
        "columnWidths": {column: _width(column) for column in (_NAME, _CREATED, *columns)},
    }


def grouped(names: Sequence[str]) -> State:
    """Return the grouping of runs by parameters; charts show the means of groups."""
    keys = [{"mode": "param", "groupByData": name} for name in names]
    return {"groupBy": {"aggregateFunction": "average", "groupByKeys": keys}, "useGroupedValuesInCharts": True}


def visible(runs: Literal["all", "first 20"]) -> State:
    """Return which runs are drawn in charts."""
    return {"runsHiddenMode": {"all": "SHOW_ALL", "first 20": "FIRST_20_RUNS"}[runs]}


def charts(sections: Mapping[str, tuple[int, Sequence[State]]]) -> State:
    """Return the page of charts.

    Args:
        sections: by title the number of charts side by side, and the charts.
    """
    return {
        "compareRunSections": [_section(title, columns) for title, (columns, _) in sections.items()],
        "compareRunCharts": [
            {**chart, "metricSectionId": title} for title, (_, cards) in sections.items() for chart in cards
        ],
        # Otherwise the UI reorders the sections.
        "isAccordionReordered": True,
        "hideEmptyCharts": True,
    }


def lines(metric: str, *, logarithmic: bool) -> State:
    """Return a chart of a metric over its steps, with a line for each run or group."""
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
    """Return a chart of a metric's last value, with a bar for each run or group."""
    return {**_chart("BAR", metric), "metricKey": metric}


def no_bars(metric: str) -> State:
    """Return a deleted chart of a metric; without it, the UI would add a chart."""
    return {**bars(metric), "deleted": True, "isGenerated": True}


def parallel_coordinates(names: Sequence[str], metric: str) -> State:
    """Return a chart with a line for each run through its parameters to a metric; runs that lack one are left out."""
    chosen = {"selectedParams": list(names), "selectedMetrics": [metric], "showAllRuns": True}
    return {**_chart("PARALLEL", f"parallel {metric}"), **chosen}


def _chart(kind: str, name: str) -> State:
    own = {"type": kind, "uuid": name, "displayName": name}
    return {**own, "deleted": False, "isGenerated": False, "runsCountToCompare": 20}


def _section(title: str, columns: int) -> State:
    own = {"uuid": title, "name": title, "columns": columns, "cardHeight": 400}
    return {**own, "display": True, "isReordered": True, "deleted": False, "isGenerated": False}


def _width(column: str) -> int:
    """Return a width in pixels at which the heading of a column is readable."""
    heading = column.partition("`")[2]
    return _WIDTHS.get(column) or max(_NARROWEST, _LETTER * len(heading) + _MARGIN)
