"""The audit of readings: points of each reading, ranking by fit, and missing cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from omegaconf import OmegaConf

from rl_design_space.analysis.fit import fit
from rl_design_space.plan.planner import Planner
from rl_design_space.plan.study import Study, load_study, plan_study
from rl_design_space.report.base import MAIN
from rl_design_space.report.published_table import PublishedTable
from rl_design_space.report.reading_points import ReadingPoints
from rl_design_space.report.readings_audit import JOINT, LIMIT, ReadingsAudit
from rl_design_space.report.readings_text import _times
from rl_design_space.report.runs import Runs
from tests.points import planning, shipped_study
from tests.report.readers import LearningReader, unpadded

GRID = {"exploration": "linear", "exploration.k": 0.03, "world.size": "4,5", "task.goals": "1,2", "task.periods": 20}
SMALL = {**GRID, "task.trials": 6}
BLOCKS = {
    "ad_hoc": {"representation": "ad_hoc", **SMALL},
    "direction": {"representation": "direction", **SMALL},
    "any": {"representation": "ad_hoc,direction", **SMALL, "learner.explore": "all"},
    "horizontal": {"representation": "direction", **SMALL, "representation.rule": "horizontal_first"},
}
READINGS = {
    "as decided": {},
    "any action": {"learner.explore": "all"},
    "horizontal": {"representation.rule": "horizontal_first"},
}
AUDIT = ReadingsAudit(
    title="Readings",
    table="table4",
    decided={"learner.explore": "non_greedy", "representation.rule": "dominant_axis"},
    readings=READINGS,
    named_periods=500,
)


@pytest.fixture(scope="module")
def study() -> Study:
    with planning() as planner:
        config = OmegaConf.create({"study": {"blocks": BLOCKS}})
        return Study("audit", (), config, plan_study("audit", config, (), planner))


def table_of(study: Study, explore: dict[str, str]) -> PublishedTable:
    """Return published numbers that are those of a reading, which may be another one in each panel."""
    shipped = shipped_study("table4").report()
    runs = Runs.of_study(study, LearningReader(study.plan))
    common = {name: value for name, value in SMALL.items() if "," not in str(value)}
    published: dict = {}
    for representation, action in explore.items():
        own = {"representation.rule": "dominant_axis"} if representation == "direction" else {}
        for size in (4, 5):
            for goals in (1, 2):
                here = {"representation": representation, "world.size": size, "task.goals": goals}
                where = {**here, **common, **own, "learner.explore": action}
                mean = runs.result(runs.one(where)).total_steps.mean() * 10 / size
                published.setdefault(representation, {}).setdefault(size, {})[goals] = float(mean)
    return PublishedTable(**{**vars(shipped), "published": published})


@pytest.fixture(scope="module")
def table(study: Study) -> PublishedTable:
    """Published numbers that are what the reading `as decided` gives, so that it fits to the last digit."""
    return table_of(study, {"ad_hoc": "non_greedy", "direction": "non_greedy"})


def audited(
    study: Study, table: PublishedTable, missing: tuple[str, ...] = (), frame: str = MAIN, audit: ReadingsAudit = AUDIT
) -> pd.DataFrame:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ReadingsAudit, "published_table", lambda self: table)
        return audit.frames(Runs.of_study(study, LearningReader(study.plan, missing)))[frame]


def test_the_reading_that_made_the_numbers_fits_best(study: Study, table: PublishedTable):
    fits = audited(study, table)
    best = fits.groupby("panel").first()
    assert best["reading"].tolist() == ["as decided", "as decided"]
    assert best["rms"].tolist() == pytest.approx([0, 0], abs=1e-12)
    others = fits[fits["reading"] == "any action"]
    assert (others["ci_low"] > 0.01).all()


def test_a_reading_is_left_out_where_it_makes_no_difference(study: Study, table: PublishedTable):
    fits = audited(study, table)
    assert fits.groupby("panel")["reading"].apply(set).to_dict() == {
        "ad_hoc": {"as decided", "any action"},
        "direction": {"as decided", "any action", "horizontal"},
    }


def test_a_reading_with_a_missing_cell_is_last_and_without_numbers(study: Study, table: PublishedTable):
    decided = next(p for p in study.plan if p.options["representation"] == "ad_hoc")
    last = audited(study, table, (decided.fingerprint,)).query("panel == 'ad_hoc'").iloc[-1]
    assert (last["reading"], last["cells"], last["of"]) == ("as decided", 3, 4)
    assert np.isnan(last["rms"])
    joint = audited(study, table, (decided.fingerprint,), JOINT)
    # A reading of direction alone has the ad hoc cells of what was decided for.
    assert joint["reading"].tolist() == ["any action", "as decided", "horizontal"]
    assert joint["joint"].isna().tolist() == [False, True, True]
    assert joint["cells"].tolist() == [8, 7, 7]


def test_readings_are_ranked_by_their_likelihood_over_all_panels(study: Study, table: PublishedTable):
    joint = audited(study, table, frame=JOINT)
    behind = joint.set_index("reading")["behind"]
    # With few periods a reading that changes little can be as likely as the true one.
    assert behind["as decided"] < np.log(LIMIT) < behind["any action"]
    assert joint["behind"].iloc[0] == 0
    assert joint["behind"].is_monotonic_increasing
    assert joint["joint"].tolist() == pytest.approx((joint["ad_hoc"] + joint["direction"]).tolist())
    assert joint["periods"].between(100, 2000).all()
    assert (joint["joint_at_named"] <= joint["joint"]).all()


def test_a_reading_that_fits_one_panel_alone_is_marked(study: Study, table: PublishedTable):
    joint = audited(study, table_of(study, {"ad_hoc": "all", "direction": "non_greedy"}), frame=JOINT)
    assert joint.set_index("reading")["one_panel"].to_dict() == {
        "as decided": "direction",
        "any action": "ad_hoc",
        "horizontal": "direction",
    }
    assert set(joint["fits"]) == {1}
    # It loses to a reading that fits both.
    both = audited(study, table, frame=JOINT).set_index("reading")
    assert (both.loc["as decided", "one_panel"], both.loc["as decided", "fits"]) == ("", 2)
    assert joint["joint"].max() < both.loc["as decided", "joint"] - 4


def test_files_hold_ranking_commands_and_missing_points(
    study: Study, table: PublishedTable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(ReadingsAudit, "published_table", lambda self: table)
    reader = LearningReader(study.plan, (study.plan[0].fingerprint,))
    paths = AUDIT.write(study, reader, tmp_path)
    assert {path.name for path in paths} == {"audit.png", "audit.svg", "audit.csv", "audit_joint.csv", "audit.md"}
    text = (tmp_path / "audit.md").read_text(encoding="utf-8")
    assert "| any action | `learner.explore=all` |" in unpadded(text)
    assert "**Missing: 1 of 20 points**; `rl-design-space study=audit` makes them." in text
    assert "missing: 1 cells" in text
    assert "times less likely at P = 500" in text
    assert "Of 1 readings, 1 are at most 100 times less likely than the best one" in text
    joint = pd.read_csv(tmp_path / "audit_joint.csv")
    assert joint.columns.tolist() == [
        "reading", "joint", "behind", "periods", "joint_at_named", "fits", "one_panel", "cells", "of",
        "log_likelihood_ad_hoc", "log_likelihood_direction",
    ]  # fmt: skip
    assert pd.read_csv(tmp_path / "audit.csv").columns.tolist() == [
        "reading", "panel", "cells", "of", "rms", "ci_low", "ci_high", "bias", "bias_low", "bias_high", "largest",
        "log_likelihood",
    ]  # fmt: skip
    assert "quick look" in (tmp_path / "audit.svg").read_text(encoding="utf-8")


def test_the_shipped_audits_know_every_reading_by_its_points(planner: Planner):
    for name in ("readings", "readings_pairs"):
        study = load_study(name, (), planner)
        table = load_study("table4", (), planner).report()
        audit: ReadingsAudit = study.report()
        runs = Runs.of_study(study, LearningReader(study.plan))
        points = ReadingPoints(runs.points, list(table.axes.values()), audit.decided, audit.readings)
        chosen = set()
        for reading in audit.combinations():
            cells = [points.under(panel, reading.values) for panel in table.published]
            assert [len(each) for each in cells] == [9, 9], reading.name
            chosen |= {point.planned.fingerprint for each in cells for seeds in each.values() for point in seeds}
        assert chosen == {planned.fingerprint for planned in study.plan}


def test_times_less_likely_are_read_at_a_glance():
    assert [_times(np.log(times)) for times in (1, 1.24, 9.9, 37.2, 9999, 1e4, 3e12)] == [
        "1", "1.2", "9.9", "37", "9,999", "10^4", "10^12",
    ]  # fmt: skip


# The fit.


def test_a_fit_by_hand():
    fitted = fit([(np.full(30, 110.0), 100.0), (np.full(30, 50.0), 100.0)])
    ratios = np.log([1.1, 0.5])
    assert fitted.rms.value == pytest.approx(np.sqrt((ratios**2).mean()))
    assert fitted.bias.value == pytest.approx(ratios.mean())
    assert fitted.largest == pytest.approx(np.log(2))
    assert fitted.rms.low == pytest.approx(fitted.rms.value)


@given(st.floats(0.2, 5))
def test_half_and_twice_are_equally_far(factor: float):
    values = np.linspace(50, 150, 40)
    over, under = (fit([(values * scale, 100.0)]).rms.value for scale in (factor, 1 / factor))
    assert over == pytest.approx(under, abs=1e-9)
