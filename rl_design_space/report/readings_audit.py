"""The audit of readings: which reading of a text makes its own numbers most likely."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, ClassVar

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._markdown import code
from rl_design_space._strict import STRICT
from rl_design_space.analysis.likelihood import PERIODS, joint_fit
from rl_design_space.config.compose import Composer, shipped_config
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study
from rl_design_space.plan.variations import Combination, Variations
from rl_design_space.report.base import MAIN, Frames, Report
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.reading_fits import PanelFit, PanelFits
from rl_design_space.report.reading_points import Cells, ReadingPoints
from rl_design_space.report.readings_picture import draw_readings
from rl_design_space.report.readings_text import distances, likelihoods
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.selection import Where

#: What the name of the CSV file of whole readings adds to that of the report.
JOINT = "_joint"
#: A reading fits a panel that is at most so many times less likely under it than under the best reading of this panel.
LIMIT = 100
_Combinations = Annotated[tuple[Annotated[tuple[str, ...], Field(strict=False)], ...], Field(strict=False)]
_FIT = ["rms", "ci_low", "ci_high", "bias", "bias_low", "bias_high", "largest"]
_COLUMNS = ["reading", "panel", "cells", "of", *_FIT, "log_likelihood"]
_JOINT_COLUMNS = ["reading", "joint", "behind", "periods", "joint_at_named", "fits", "one_panel", "cells", "of"]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ReadingsAudit(Report):
    """Readings ranked by how likely a published table is under each, over all of its panels.

    Attributes:
        table: the study whose report has the published numbers, a `PublishedTable`.
        decided: values of parameters that a point has unless its reading says otherwise.
        readings: what each reading says, by its name; the one that says nothing is the one that was decided for.
        order: largest number of readings that are combined, as in the `variations` of a study.
        also, around: further combinations, as there.
        named_periods: periods of a mean, if the text names them; one of `analysis.likelihood.PERIODS`.
    """

    shows: str = "Readings ranked by how likely the published numbers are under each, by panel and over all panels"
    table: str
    decided: Where
    readings: dict[str, Where]
    order: Annotated[int, Field(ge=1)] = 1  # type: ignore[assignment]  # see `own`
    also: _Combinations = ()
    around: _Combinations = ()
    named_periods: int | None = None

    own: ClassVar[Sequence[str]] = ("order",)

    def __post_init__(self) -> None:
        if self.named_periods not in (None, *PERIODS):
            raise ConfigError.at(
                "named_periods", self.named_periods, f"should be one of {', '.join(map(str, PERIODS))}"
            )

    def frames(self, runs: Runs) -> Frames:
        """Return the fit of each reading, to each panel and to all of them; see `analysis.likelihood` and `.fit`.

        Returns:
            The main frame has a row for each panel that a reading changes, the best rms first: reading, panel, cells
            (recorded), of (published), rms, ci_low, ci_high, bias, bias_low, bias_high, largest (log ratios),
            log_likelihood (of the panel).

            The frame `JOINT` has a row for each reading, the most likely one first: reading, joint (log likelihood of
            all panels), behind (that of the best reading minus joint), periods (P), joint_at_named (joint at
            `named_periods`), fits (how many panels it fits, see `LIMIT`), one_panel (the panels that it fits if it does
            not fit all), cells, of, and the log likelihood of each panel under the panel's name.

            Readings without all cells come last, without numbers. Not written: title (of the panel), says (what the
            reading says), decided (whether it is the one that was decided for).
        """
        published = self.published_table()
        panels = {panel: published.label(panel) for panel in published.published}
        fitted = PanelFits(runs, published)
        known: set[object] = set()
        rows, joint = [], []
        points = ReadingPoints(runs.points, list(published.axes.values()), self.decided, self.readings)
        for reading, cells in self._distinct(points, fitted, panels):
            fits = {panel: fitted(panel, cells[panel]) for panel in panels}
            said = {"reading": reading.name, "says": _in_words(reading.values), "decided": not reading.values}
            whole = {**said, **_joint(fits, self.named_periods)}
            joint.append(whole)
            for panel, each in fits.items():
                if (key := fitted.key(panel, cells[panel])) not in known:  # else the reading makes no difference here
                    known.add(key)
                    place = {"panel": panel, "title": panels[panel], "log_likelihood": whole[panel]}
                    rows.append({**said, **place, **_distance(each)})
        main = pd.DataFrame(rows).sort_values(["panel", "rms"], ignore_index=True)
        return {MAIN: main, JOINT: _ranked(pd.DataFrame(joint), list(panels))}

    def csv(self, frames: Frames) -> Frames:
        written = {panel: f"log_likelihood_{panel}" for panel in _titles(frames)}
        joint = frames[JOINT][[*_JOINT_COLUMNS, *written]].rename(columns=written)
        return {MAIN: frames[MAIN][_COLUMNS], JOINT: joint}

    def draw(self, frames: Frames) -> Figure:
        return draw_readings(frames[JOINT], frames[MAIN], _titles(frames), self.title, LIMIT)

    def text(self, frames: Frames) -> list[str]:
        """Return the first readings by likelihood over all panels, and by the distance from each panel."""
        titles = _titles(frames)
        return [*likelihoods(frames[JOINT], titles, LIMIT, self.named_periods), *distances(frames[MAIN], titles)]

    def published_table(self) -> PublishedTable:
        """Return the report with the published numbers.

        Raises:
            ConfigError: the study has another report.
        """
        with shipped_config():
            config = Composer().config([f"study={self.table}"])
        report = Study(self.table, (), config, Plan([])).report()  # the numbers of the table need no points
        if not isinstance(report, PublishedTable):
            raise ConfigError.at("report.table", self.table, "should be a study whose report is a PublishedTable")
        return report

    def combinations(self) -> Sequence[Combination]:
        """Return all readings: single ones, then combined ones.

        Raises:
            ConfigError: `around` names readings that there are not.
        """
        readings = {name: {**says} for name, says in self.readings.items()}
        return Variations(readings=readings, order=self.order, also=self.also, around=self.around).combinations

    def _distinct(
        self, points: ReadingPoints, fitted: PanelFits, panels: Mapping[Any, str]
    ) -> Iterator[tuple[Combination, Mapping[Any, Cells]]]:
        """Yield readings with their points by panel; those whose points are those of an earlier one are left out."""
        known: set[object] = set()
        for reading in self.combinations():
            cells = {panel: points.under(panel, reading.values) for panel in panels}
            key = tuple(fitted.key(panel, cells[panel]) for panel in panels)
            if key not in known:
                known.add(key)
                yield reading, cells


def _joint(fits: Mapping[Any, PanelFit], named: int | None) -> dict[Any, Any]:
    """Return the fit of a reading to all panels."""
    found: dict[Any, Any] = {
        "joint": math.nan,
        "periods": math.nan,
        "joint_at_named": math.nan,
        "cells": sum(each.recorded for each in fits.values()),
        "of": sum(each.published for each in fits.values()),
        **dict.fromkeys(fits, math.nan),
    }
    densities = {panel: each.densities for panel, each in fits.items() if each.densities is not None}
    if len(densities) == len(fits):
        joint = joint_fit(densities)
        found |= {"joint": joint.total, "periods": joint.periods, **joint.panels}
        found["joint_at_named"] = joint.at[named] if named else math.nan
    return found


def _distance(fitted: PanelFit) -> dict[str, Any]:
    """Return the distance of the means of a panel from the published ones."""
    numbers: tuple[float, ...] = (math.nan,) * len(_FIT)
    if fitted.fit:
        numbers = (*fitted.fit.rms, *fitted.fit.bias, fitted.fit.largest)
    return {"cells": fitted.recorded, "of": fitted.published, **dict(zip(_FIT, numbers, strict=True))}


def _ranked(joint: pd.DataFrame, panels: list[Any]) -> pd.DataFrame:
    """Return readings by their joint likelihood, and how many times less likely than the best they are."""
    behind = joint[panels].max() - joint[panels]
    fits = behind <= math.log(LIMIT)
    alone = fits.any(axis=1) & ~fits.all(axis=1)
    named = [", ".join(str(panel) for panel in panels if here[panel]) for here in fits.to_dict("records")]
    return joint.assign(
        behind=joint["joint"].max() - joint["joint"],
        fits=fits.sum(axis=1),
        one_panel=np.where(alone, named, ""),
    ).sort_values("joint", ascending=False, kind="stable", ignore_index=True)


def _titles(frames: Frames) -> dict[Any, str]:
    """Return the title of each panel."""
    return dict(frames[MAIN][["panel", "title"]].drop_duplicates().itertuples(index=False))


def _in_words(says: Where) -> str:
    return ", ".join(code(f"{name}={value}") for name, value in says.items()) or "the defaults"
