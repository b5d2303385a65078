"""A page to explore any runs: one file, in which rows, columns, values and filters are chosen."""

from __future__ import annotations

import base64
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.colors import to_hex

from rl_design_space._arrays import FloatArray
from rl_design_space._visible import visible
from rl_design_space.errors import ConfigError
from rl_design_space.report import style
from rl_design_space.report.look import Look
from rl_design_space.report.ordering import Ordering
from rl_design_space.report.parameters import text
from rl_design_space.report.points import frame_with_defaults
from rl_design_space.report.together import together
from rl_design_space.report.watching import Watch, unwatched
from rl_design_space.tracking.run_frame import ABOUT

if TYPE_CHECKING:
    from rl_design_space.tracking.read import RunReader

_TEMPLATE, _SCRIPT, _STYLE = "explore.html.jinja", "explore.js", "explore.css"
#: The space before an override; others are within a value.
_NEXT = re.compile(r" (?=[+~]*[\w./@]+=)")
#: What makes two runs different, but is no choice.
_NOT_CHOICES = ("fingerprint",)
#: Colours of a colour map that cells and lines have.
_SHADES, _LINES = 11, 12
_USUAL = Look()


def page_data(
    frame: pd.DataFrame,
    numbers: Sequence[str],
    curves: Mapping[str, Sequence[FloatArray]],
    address: str,
    look: Look = _USUAL,
    listed: Mapping[str, Iterable[Any]] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return what the page shows, as plain values.

    Args:
        frame: runs, as `RunReader.frame` returns them.
        numbers: columns of the frame that are shown as values; those without a number are left out.
        curves: learning curves by name, of each run.
        address: of a run in the MLflow UI, with RUN_ID where its id stands.
        look: labels, order, scale and colour map.
        listed: values of each parameter in the order of the study of the runs.

    Returns:
        parameters: name, values (as text, in order) and index (of its value, for each run) of those that differ.
        fixed: name and value of those that do not.
        numbers: name and values, of each run.
        curves: name, trials and values: float32 of all runs one after the other, in base 64, NaN where a run has fewer
            trials.
        runs: ids, and the commands that run their points.
        address: as given.
        look: labels by name, the scale, and the colours of cells and lines; empty where none were chosen.

    Raises:
        ConfigError: the order has a parameter or value that no run has.
    """
    ordering = _ordering(frame, look, listed)
    names = [name for name in frame.columns if name not in (*ABOUT, *numbers, *_NOT_CHOICES)]
    parameters, fixed = [], {}
    for name in names:
        column = [None if pd.isna(value) else value for value in frame[name]]
        values = sorted(set(column), key=lambda value, name=name: ordering.key(name, value))  # type: ignore[misc]
        if len(values) == 1:
            fixed[visible(name)] = visible(text(values[0]))
            continue
        place = {value: number for number, value in enumerate(values)}
        parameters.append(
            {
                "name": visible(name),
                "values": [visible(text(value)) for value in values],
                "index": [place[value] for value in column],
            }
        )
    return {
        "parameters": parameters,
        "fixed": fixed,
        "numbers": [
            {"name": name, "values": [_plain(value) for value in frame[name]]}
            for name in numbers
            if frame[name].notna().any()
        ],
        "curves": [_packed(name, each) for name, each in curves.items()],
        "runs": {"ids": list(frame.index), "commands": [_command(str(name)) for name in frame["name"]]},
        "address": address,
        "look": {"labels": look.words.labels, "scale": look.scale, **_colours(look.colour_map)},
    }


def _ordering(frame: pd.DataFrame, look: Look, listed: Mapping[str, Iterable[Any]]) -> Ordering:
    if unknown := [name for name in look.order if name not in frame]:
        raise ConfigError.unknown("parameter of these runs", unknown[0], map(str, frame.columns), "order.")
    known = {name: {None if pd.isna(value) else value for value in frame[name]} for name in look.order}
    return Ordering.of_study(listed).replaced(look.order, known)


def _colours(name: str) -> dict[str, list[Any]]:
    """Return colours of cells as red, green and blue, and those of lines; none if no colour map was chosen."""
    if not name:
        return {"cells": [], "lines": []}
    cells = [[round(255 * part) for part in colour[:3]] for colour in mpl.colormaps[name](np.linspace(0, 1, _SHADES))]
    return {"cells": cells, "lines": [to_hex(colour) for colour in style.colours(_LINES, name)]}


def render(data: Mapping[str, Any], title: str, made_by: str) -> str:
    """Return the page as HTML: the data, a library that draws, and what reacts to choices.

    Args:
        data: see `page_data`.
        title: of the page.
        made_by: command that wrote it.

    Raises:
        ConfigError: the library is not installed.
    """
    try:
        from plotly.offline import get_plotlyjs
    except ImportError as missing:
        raise ConfigError("explore: needs Plotly; pip install 'rl-design-space[explore]'") from missing
    loader = PackageLoader("rl_design_space.report", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    templates = Path(__file__).parent / "templates"
    return environment.get_template(_TEMPLATE).render(
        title=title,
        made_by=made_by,
        data=data,
        library=_inline(get_plotlyjs()),
        script=_inline((templates / _SCRIPT).read_text(encoding="utf-8")),
        style=(templates / _STYLE).read_text(encoding="utf-8"),
    )


def write_explorer(
    frame: pd.DataFrame,
    reader: RunReader,
    path: Path,
    *,
    numbers: Sequence[str],
    curves: Sequence[str],
    ui: str,
    title: str,
    made_by: str,
    watch: Watch = unwatched,
    look: Look = _USUAL,
    listed: Mapping[str, Iterable[Any]] = MappingProxyType({}),
) -> list[Path]:
    """Write the page of runs.

    Args:
        frame: runs that were found by `reader`.
        reader: of the tracking store.
        path: of the file.
        numbers: scalars and measures, columns of the frame.
        curves: names of learning curves.
        ui: address of the MLflow UI, for links to the runs.
        title: of the page.
        made_by: command that writes it.
        watch: shows how far the reading is.
        look: see `page_data`.
        listed: see `page_data`.

    Raises:
        ConfigError: there is no run or no such curve, or the library that draws is not installed.
    """
    if frame.empty:
        raise ConfigError("no run was selected; `rl-design-space store status` says what is recorded")
    found: dict[str, list[FloatArray]] = {name: [] for name in curves}
    read = reader.arrays(frame)
    for _ in watch(list(frame.index), "reading learning curves"):
        _, arrays = next(read)
        for name in curves:
            if name not in arrays or arrays[name].ndim != 1:
                raise ConfigError.unknown("learning curve", name, [each for each in arrays if "/" in each])
            found[name].append(arrays[name])
    data = page_data(frame_with_defaults(frame), numbers, found, reader.run_link(ui, "RUN_ID"), look, listed)
    content = render(data, title, made_by)
    with together(path.parent) as new:
        (new / path.name).write_text(content, encoding="utf-8")
    return [path]


def _plain(value: Any) -> float | None:
    """Return a number with six digits, which halves the page; None if there is none."""
    return None if pd.isna(value) else float(f"{value:.6g}")


def _packed(name: str, curves: Sequence[FloatArray]) -> dict[str, Any]:
    trials = max((len(curve) for curve in curves), default=0)
    table = np.full((len(curves), trials), np.nan, dtype="<f4")
    for row, curve in zip(table, curves, strict=True):
        row[: len(curve)] = curve
    return {"name": name, "trials": trials, "values": base64.b64encode(table.tobytes()).decode()}


def _command(name: str) -> str:
    """Return the command of a point from the name of its run, which is made of its overrides."""
    overrides = _NEXT.split(visible(name)) if "=" in name else []
    return shlex.join(["rl-design-space", *overrides])


def _inline(script: str) -> str:
    """Return a script that can stand in a page."""
    return script.replace("</script", r"<\/script")
