"""The ledger from points to files: verdicts, missing points and invalid claims."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from rl_design_space.analysis.claims import Verdict
from rl_design_space.config.build import build
from rl_design_space.errors import ConfigError
from rl_design_space.plan.plan import Plan
from rl_design_space.plan.study import Study, plan_overrides
from rl_design_space.report import ClaimsLedger
from rl_design_space.report.claims_judged import claims_frame, parts_frame
from rl_design_space.report.runs import Runs
from tests.points import planning, shipped_study
from tests.report.readers import LearningReader, unpadded

LEVEL, RATIO = "rl_design_space.analysis.parts.Level", "rl_design_space.analysis.parts.Ratio"
SWEEP = ["task.periods=40", "task.trials=12", "task.goals=1", "exploration=linear", "world.size=4,8"]


@pytest.fixture(scope="module")
def study() -> Study:
    """Two sizes of one point; the ledger is not of a file."""
    with planning() as planner:
        return Study("mine", (), planner.composer.config(()), plan_overrides(SWEEP, planner))


def ratio(low: float, **more: object) -> dict:
    sizes = {"point": {"world.size": 8}, "to": {"world.size": 4}}
    return {"_target_": RATIO, "what": "8 / 4", "measure": "total_steps", "low": low, **sizes, **more}


def ledger(**claims: list) -> ClaimsLedger:
    nodes = {name: {"statement": f"says {name}", "study": "mine", "parts": parts} for name, parts in claims.items()}
    values = {"title": "Claims", "common": {"exploration": "linear"}, "claims": nodes}
    return build("study.report", {"_target_": "rl_design_space.report.ClaimsLedger", **values})


def judged(study: Study, missing: tuple[str, ...] = (), **claims: list):
    return ledger(**claims).judged(Runs.of_study(study, LearningReader(study.plan, missing)))


def test_verdicts_turn_with_what_is_claimed(study: Study):
    found = judged(study, larger=[ratio(1.5)], much_larger=[ratio(50.0)], nothing=[])
    assert [each.finding.verdict for each in found] == [
        Verdict.REPRODUCED,
        Verdict.NOT_REPRODUCED,
        Verdict.UNDECIDED,
    ]


def test_a_missing_point_leaves_a_claim_undecided_and_is_named(study: Study):
    missing = study.plan[1]
    found = judged(study, (missing.fingerprint,), larger=[ratio(1.5)])
    assert found[0].finding.verdict == Verdict.UNDECIDED
    assert found[0].missing == [f"missing: {missing.command}"]
    assert claims_frame(found).loc[0, "what"] == f"missing: {missing.command}"


def test_files_hold_what_was_judged(study: Study, tmp_path: Path):
    reader = LearningReader(study.plan)
    paths = ledger(larger=[ratio(1.5), ratio(2.0, what="twice")], nothing=[]).write(study, reader, tmp_path)
    assert {path.name for path in paths} == {f"mine.{s}" for s in ("png", "svg", "csv", "md")} | {"mine_parts.csv"}
    claims, parts = pd.read_csv(tmp_path / "mine.csv"), pd.read_csv(tmp_path / "mine_parts.csv")
    assert claims["claim"].tolist() == ["larger", "nothing"]
    assert claims["verdict"].tolist() == ["reproduced", "undecided"]
    assert parts["what"].tolist() == ["8 / 4", "twice"]
    decisive = parts.set_index("what").loc[claims.loc[0, "what"]]
    assert (claims.loc[0, "value"], claims.loc[0, "ci_low"]) == (decisive["value"], decisive["ci_low"])
    text = (tmp_path / "mine.md").read_text(encoding="utf-8")
    assert "**2 claims: 1 reproduced, 0 not reproduced, 1 undecided.**" in text
    assert "| larger | says larger | reproduced |" in unpadded(text)
    assert "nothing to measure" in text
    picture = (tmp_path / "mine.svg").read_text(encoding="utf-8")
    assert "8 / 4" in picture
    assert "quick look: 40 periods" in picture


def test_a_ledger_without_any_run_is_drawn(study: Study, tmp_path: Path):
    reader = LearningReader(study.plan, [planned.fingerprint for planned in study.plan])
    ledger(larger=[ratio(1.5)]).write(study, reader, tmp_path)
    assert pd.read_csv(tmp_path / "mine.csv")["verdict"].tolist() == ["undecided"]


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (ratio(1.5, measure="duration"), "claims.a.parts.0.measure: duration: no such measure (there is"),
        (ratio(1.5, lo=1.0), "lo: no such key"),
        ({"_target_": "nowhere.Part"}, "claims.a.parts.0._target_=nowhere.Part: cannot be imported"),
        (ratio(1.5, point={"world.size": 4, "world.siz": 1}), "world.siz: no such parameter"),
        (ratio(1.5, point={"exploration": "linear"}), "should be one point of"),
    ],
    ids=str,
)
def test_an_invalid_claim_is_named_in_the_error(study: Study, part: dict, message: str):
    with pytest.raises(ConfigError) as caught:
        judged(study, a=[part])
    assert message in str(caught.value)


def test_every_claim_of_the_paper_is_in_the_ledger():
    shipped = shipped_study("claims").report()
    assert list(shipped.claims) == [
        "fig2-a", "fig2-b", "s3.1-c", "fig3-a", "fig3-b", "fig3-c", "fig3-d", "fig4-a", "fig4-b", "fig4-c",
        "fig5-a", "fig5-b", "fig5-c", "fig5-d", "t4-a", "s3.5-b", "s4-a",
    ]  # fmt: skip


def test_every_part_of_every_claim_finds_its_points():
    # With points so small that nothing can be said of the claims themselves.
    few = ("task.trials=31", "task.max_steps=50")
    study = shipped_study("claims", "task.periods=2", *few)
    report = study.report()
    more = shipped_study(report.larger_samples, "task.periods=3", *few)
    reader = LearningReader(Plan((*study.plan, *more.plan)))
    found = report.judged(Runs.of_study(study, reader).with_larger(Runs.of_study(more, reader), "rl more"))
    assert {each.name for each in found if each.later_periods == [3]} == set(report.on_larger_samples)
    assert {each.name: each.missing for each in found if each.missing} == {}
    assert {each.name: each.later_missing for each in found if each.later_missing} == {}
    assert {each.name for each in found if not each.finding.parts} == {"s4-a"}
    assert {each.name for each in found if each.later and not each.later.parts} == set()


def test_a_part_is_read_from_plain_yaml(study: Study):
    level = {
        "_target_": LEVEL,
        "what": "final",
        "measure": "final_over_optimum",
        "high": 900.0,
        "point": {"world.size": 4},
    }
    (found,) = judged(study, a=[level])
    assert parts_frame([found])["state"].tolist() == ["holds"]
    assert replace(found, missing=("x",)).claim.study == "mine"
