"""The multiverse from points to files, on made-up results that follow from the reading."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from omegaconf import OmegaConf

from rl_design_space.analysis.multiverse.marks import Mark
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan, PlannedPoint
from rl_design_space.plan.study import Study, plan_study
from rl_design_space.report.base import MAIN
from rl_design_space.report.multiverse import CLAIMS, FACTORS, JOINT, Multiverse
from rl_design_space.report.runs import Runs
from rl_design_space.tracking.tracker import StoredRun
from tests.points import planning, shipped_study
from tests.report.readers import unpadded

PERIODS, TRIALS = 30, 12
PARTS = "rl_design_space.analysis.parts."
FIRST, PRINTED, GOALS = "first of equal maxima", "update as printed", "all goals"
READINGS = {
    FIRST: {"learner.ties": "first"},
    PRINTED: {"learner.update": "printed"},
    GOALS: {"representation.goals": "all"},
}
DECIDED = {"learner.ties": "random", "learner.update": "standard", "representation.goals": "remaining"}
BLOCKS = {
    "ad_hoc": {"representation": "ad_hoc", "exploration": "linear", "exploration.k": "0.02,0.03,0.05"},
    "direction": {"representation": "direction", "exploration": "linear", "exploration.k": "0.03"},
}
BEST = {
    "_target_": f"{PARTS}WithinOfAll", "what": "k = 0.03 / best k", "measure": "best", "high": "near",
    "parameter": "exploration.k", "expected": 0.03, "among": {"representation": "ad_hoc"},
}  # fmt: skip
SLOWER = {
    "_target_": f"{PARTS}Ratio", "what": "direction / ad hoc", "measure": "fast", "low": "clearly",
    "point": {"representation": "direction"}, "to": {"representation": "ad_hoc", "exploration.k": 0.03},
}  # fmt: skip
#: (parameters of a point) -> factor of its steps.
World = Callable[[dict[str, Any]], float]


@pytest.fixture(scope="module")
def study() -> Study:
    node = {"blocks": BLOCKS, "variations": {"order": 2, "readings": READINGS}}
    overrides = (f"task.periods={PERIODS}", f"task.trials={TRIALS}", "world.size=4", "task.goals=1")
    with planning() as planner:
        config = OmegaConf.create({"study": node})
        return Study("made", overrides, config, plan_study("made", config, overrides, planner))


class MadeUpReader:
    """Results that are a curve times a factor, which follows from the parameters of a point."""

    in_flight = 2

    def __init__(
        self, plan: Plan, world: World, missing: Callable[[PlannedPoint], bool] = lambda planned: False
    ) -> None:
        self._planned = {planned.fingerprint: planned for planned in plan}
        self._world, self._missing = world, missing

    def finished(self, fingerprints: Any) -> dict[str, StoredRun]:
        return {each: StoredRun(each) for each in fingerprints if not self._missing(self._planned[each])}

    def periods(self, run: StoredRun) -> dict[str, Any]:
        factor = self._world(self._planned[run.run_id].parameters)
        spread = 1 + 0.02 * np.sin(np.arange(PERIODS) * 2.4)[:, np.newaxis]
        steps = np.round(1000 * factor * np.exp(-np.arange(TRIALS) / 4) * spread + 100).astype(np.int32)
        return {
            "steps": steps, "success": np.ones_like(steps, bool), "optimum": np.full(PERIODS, 100, np.int32),
            "rows": np.zeros((PERIODS, 2), np.int32), "epsilon": np.ones(TRIALS),
        }  # fmt: skip


def multiverse(**claims: dict[str, Any]) -> Multiverse:
    return Multiverse(
        title="Multiverse", ledger="claims", common={"exploration": "linear"}, decided=DECIDED, readings=READINGS,
        apart={"representation.goals": "representation"},
        roles={role: {"measures": ["total_steps", "steps_after=3"]} for role in ("best", "fast")},
        thresholds={"as registered": {"near": 1.05, "clearly": 1.2}, "lenient": {"near": 1.1, "clearly": 1.1}},
        claims=claims,
    )  # fmt: skip


BEST_AND_SLOWER = {"fig3-a": {"role": "best", "parts": [BEST]}, "fig2-b": {"role": "fast", "parts": [SLOWER]}}


def only_with_first_maximum(parameters: dict[str, Any]) -> float:
    """The paper's k is the best if the first of equal maxima is chosen, and not else; direction is slower anyhow."""
    if parameters["representation"] == "direction":
        return 4.0
    best = 0.03 if parameters["learner.ties"] == "first" else 0.05
    return 1.0 if parameters["exploration.k"] == best else 2.0


def frames_of(study: Study, world: World, report: Multiverse) -> dict[str, pd.DataFrame]:
    return dict(report.frames(Runs.of_study(study, MadeUpReader(study.plan, world))))


@pytest.fixture(scope="module")
def frames(study: Study) -> dict[str, pd.DataFrame]:
    return frames_of(study, only_with_first_maximum, multiverse(**BEST_AND_SLOWER))


def claim(frames: dict[str, pd.DataFrame], name: str) -> pd.Series:
    return frames[CLAIMS].set_index("claim").loc[name]


def test_a_claim_that_is_true_under_one_reading_alone_gets_exactly_that_mark(frames: dict[str, pd.DataFrame]):
    found = claim(frames, "fig3-a")
    assert (found["mark"], found["choices"], found["within"]) == (Mark.UNDER, "learner.ties=first", 1)
    assert (found["hangs_on"], found["first"], found["total"]) == ("learner.ties", pytest.approx(1), pytest.approx(1))
    rows = frames[MAIN].query("claim == 'fig3-a'")
    assert set(rows.loc[rows["holds"].eq(True), "reading"]) == {FIRST, f"{FIRST} + {PRINTED}"}


def test_a_claim_that_is_true_whatever_the_reading_holds(frames: dict[str, pd.DataFrame]):
    found = claim(frames, "fig2-b")
    assert (found["mark"], found["share"], found["clear"]) == (Mark.HOLDS, 1, 1)
    assert frames[FACTORS].query("claim == 'fig2-b'").empty


def test_every_other_claim_of_the_ledger_cannot_be_told(frames: dict[str, pd.DataFrame]):
    others = frames[CLAIMS][~frames[CLAIMS]["claim"].isin(BEST_AND_SLOWER)]
    assert len(others) == 15
    assert set(others["mark"]) == {Mark.OPEN}


def test_readings_that_change_no_point_of_a_claim_count_once(frames: dict[str, pd.DataFrame]):
    readings = frames[MAIN].groupby("claim")["reading"].agg(set)
    assert readings["fig3-a"] == {"as decided", FIRST, PRINTED, f"{FIRST} + {PRINTED}"}
    goals = f"{GOALS} (direction)"
    assert readings["fig2-b"] == readings["fig3-a"] | {goals, f"{FIRST} + {goals}", f"{PRINTED} + {goals}"}
    assert frames[MAIN].groupby("claim").size().to_dict() == {"fig3-a": 4 * 8, "fig2-b": 7 * 8}


def test_the_joint_specification_takes_the_reading_that_saves_the_claim(frames: dict[str, pd.DataFrame]):
    joint = frames[JOINT].set_index("within")
    assert joint["hold"].to_dict() == {
        "as registered": 1, "the decided reading": 1, "the registered limits": 2, "anything tried": 2,
    }  # fmt: skip
    best = joint.loc["anything tried"]
    assert (best["reading"], best["departures"], best["gains"]) == (FIRST, 1, "fig3-a")
    # Of both other values of k, 0.05 is the best under the other reading: the search finds it.
    assert (best["placebo"], best["placebo_same"], best["placebos"]) == (0.5, 0, 2)


def test_a_claim_of_one_measure_and_one_statistic(study: Study):
    def late(parameters: dict[str, Any]) -> float:
        return 1.0 if parameters["exploration.k"] == 0.03 else 1.03

    report = replace(multiverse(**BEST_AND_SLOWER), thresholds={"as registered": {"near": 1.0, "clearly": 1.2}})
    found = claim(frames_of(study, late, report), "fig3-a")
    assert found["mark"] == Mark.HOLDS
    placebo = replace(report, claims={"fig3-a": {"role": "best", "parts": [{**BEST, "expected": 0.05}]}})
    assert claim(frames_of(study, late, placebo), "fig3-a")["mark"] == Mark.NOWHERE


def test_files_and_missing_points(study: Study, tmp_path: Path):
    def is_missing(planned: PlannedPoint) -> bool:
        return planned.parameters["learner.update"] == "printed" and planned.options["representation"] == "direction"

    reader = MadeUpReader(study.plan, only_with_first_maximum, is_missing)
    paths = multiverse(**BEST_AND_SLOWER).write(study, reader, tmp_path)
    extra = {"_claims.csv", "_factors.csv", "_joint.csv", "_curve.csv", "_near.csv"}
    pictures = {f"{name}.{suffix}" for name in ("", "-fig3-a", "-fig2-b") for suffix in ("png", "svg")}
    assert {path.name.removeprefix("made") for path in paths} == {".csv", ".md", *extra, *pictures}
    specifications = pd.read_csv(tmp_path / "made.csv")
    assert list(specifications) == [
        "claim",
        "reading",
        "measure",
        "statistic",
        "threshold",
        "holds",
        "value",
        "low",
        "high",
    ]
    unknown = specifications[specifications["holds"].isna()]
    assert set(unknown["claim"]) == {"fig2-b"}
    assert unknown["reading"].str.contains(PRINTED).all()
    text = unpadded((tmp_path / "made.md").read_text(encoding="utf-8"))
    assert "**holds under learner.ties=first**" in text
    assert "fig2-b: missing: rl-design-space" in text
    assert "![Specification curve of fig3-a" in text


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"claims": {"fig3-x": {"parts": [BEST]}}}, "no such claim"),
        ({"claims": {"fig3-a": {"role": "bst", "parts": [BEST]}}}, "did you mean best"),
        ({"claims": {"fig3-a": {"role": "best", "parts": [{**BEST, "high": "nera"}]}}}, "did you mean near"),
        ({"claims": {"fig3-a": {"role": "best", "parts": [{**BEST, "measure": "bst"}]}}}, "bst: no such measure"),
        ({"ledger": "fig2"}, "report.ledger=fig2: should be a study whose report is a ClaimsLedger"),
    ],
    ids=str,
)
def test_a_mistake_is_named(study: Study, changes: dict[str, Any], message: str):
    with pytest.raises(ConfigError, match=message):
        frames_of(study, only_with_first_maximum, replace(multiverse(**BEST_AND_SLOWER), **changes))


def test_the_shipped_multiverse_has_a_point_for_every_part_and_reading():
    from rl_design_space.report.multiverse_claims import MultiverseClaim, worded
    from rl_design_space.report.multiverse_outcomes import asked
    from rl_design_space.report.multiverse_points import ReadPoints, alternatives, readings_of

    study = shipped_study("multiverse")
    report: Multiverse = study.report()
    runs = Runs.of_study(study, MadeUpReader(study.plan, lambda parameters: 1.0, lambda planned: True))
    there = alternatives(report.readings, report.apart, runs.points)
    assert len(there) == 12
    assert len(readings_of(there, 2)) == 1 + 12 + 66 - 1
    points = ReadPoints(runs.points, report.decided, report.common, there)
    for name, node in report.claims.items():
        claim_ = MultiverseClaim(**node)
        for base, _ in asked(worded(name, claim_, report._roles(), report.thresholds), points):
            assert all(points.read(base, reading) for reading in readings_of(there, 2)), name
