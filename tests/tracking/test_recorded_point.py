"""Everything that is recorded of a design point."""

from __future__ import annotations

import getpass
import math
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from xml.etree import ElementTree

import hydra.utils
import numpy as np
import pytest
import yaml
from omegaconf import OmegaConf

import rl_design_space
from rl_design_space._paths import CONF
from rl_design_space.design import DesignPoint
from rl_design_space.learning import LearningCurves
from rl_design_space.learning.measures import CURVES, CURVES_ON_DEMAND, FINAL_TRIALS
from rl_design_space.learning.result import read_saved
from rl_design_space.plan.plan import PlannedPoint
from rl_design_space.tracking import content
from rl_design_space.tracking.record import ended_at, point_record
from rl_design_space.tracking.tracker import StoredRun
from tests.command_runner import output_of
from tests.points import planned_point
from tests.tracking.stores import learned, tracker_at
from tests.tracking.stores import record as record_point

if TYPE_CHECKING:
    from mlflow import MlflowClient
    from mlflow.entities import Run

OVERRIDES = ("task.trials=100", "representation=direction", "exploration=linear", "msa=lengths_2_3", "world.size=5")


class Recorded(NamedTuple):
    """A point, its result, and its run."""

    planned: PlannedPoint
    curves: LearningCurves
    stored: StoredRun
    client: MlflowClient
    run: Run

    def history(self, name: str) -> list[tuple[int, float]]:
        found = self.client.get_metric_history(self.run.info.run_id, name)
        return [(metric.step, metric.value) for metric in found]

    def artifact(self, name: str) -> Path:
        return Path(self.run.info.artifact_uri.removeprefix("file://")) / name


@pytest.fixture(scope="module")
def recorded(shared_database: Path) -> Recorded:
    from mlflow import MlflowClient

    planned, curves = learned(*OVERRIDES)
    planned = replace(planned, studies=("fig3", "table4"))
    stored = record_point(tracker_at(shared_database, curves=["epsilon", "steps/q90"]), planned, curves)
    client = MlflowClient(f"sqlite:///{shared_database}")
    return Recorded(planned, curves, stored, client, client.get_run(stored.run_id))


def test_the_run_is_finished_and_named(recorded: Recorded):
    info = recorded.run.info
    assert info.status == "FINISHED"
    assert info.run_name == "size=5 direction linear lengths_2_3 trials=100 periods=3"
    assert recorded.client.get_experiment(info.experiment_id).name == "design points"


def test_its_times_are_those_of_learning(recorded: Recorded):
    info, curves = recorded.run.info, recorded.curves
    assert info.end_time == int(1000 * curves.ended_at)
    assert abs(info.end_time - info.start_time - 1000 * curves.seconds) <= 1


def test_periods_that_were_recorded_before_do_not_count(recorded: Recorded):
    begun = replace(recorded.curves, seconds=3.0)
    written = point_record(replace(recorded.planned, begun=begun), replace(begun, seconds=5.0, ended_at=100.0), {})
    assert (written.content["started"], written.content["ended"], written.content["seconds"]) == (98_000, 100_000, 5.0)


def test_a_record_of_an_earlier_version_ends_when_it_was_written(recorded: Recorded):
    written = point_record(recorded.planned, recorded.curves, {})
    content = {name: value for name, value in written.content.items() if name != "ended"}
    assert ended_at(replace(written, content={**content, "started": 1000, "seconds": 2.5})) == 3500


def test_the_description_shows_the_curve_and_the_main_numbers(recorded: Recorded):
    picture, numbers, command = recorded.run.data.tags["mlflow.note.content"].split("\n\n")
    run_id, scalars = recorded.stored.run_id, recorded.curves.scalars()
    assert picture == f"![learning curve](get-artifact?path=curve.svg&run_uuid={run_id})"
    assert numbers.startswith(f"{scalars['total_steps']:,.0f} ± {1.96 * scalars['total_steps_sem']:,.0f} steps in 100")
    assert command == f"`{recorded.planned.command}`"
    drawn = ElementTree.parse(recorded.artifact("curve.svg")).getroot()
    (line,) = drawn.iter("{http://www.w3.org/2000/svg}polyline")
    heights = [float(pair.partition(",")[2]) for pair in line.attrib["points"].split()]
    assert len(heights) == 100
    assert heights[np.argmax(recorded.curves.curves["steps/mean"])] == min(heights)


def test_params_are_flat_and_named_as_on_the_command_line(recorded: Recorded):
    assert recorded.run.data.params == {
        "world": "torus", "representation": "direction", "exploration": "linear", "msa": "lengths_2_3",
        "reward": "many_rewards", "learner": "q_learning",
        "seed": "0",
        "task.goals": "3", "task.trials": "100", "task.periods": "3", "task.max_steps": "10000",
        "world.size": "5",
        "representation.rule": "dominant_axis", "representation.goals": "remaining",
        "exploration.start": "0.9", "exploration.k": "0.03", "exploration.first_trial": "0",
        "msa.lengths": "[2, 3]", "msa.propagation": "primitives", "msa.reward": "realised", "msa.sub_goal": "continue",
        "reward.step": "-0.1", "reward.sub_goal": "1.0", "reward.final_goal": "10.0",
        "learner.alpha": "0.1", "learner.gamma": "0.9", "learner.initial_q": "0.0", "learner.explore": "non_greedy",
        "learner.ties": "random", "learner.out_of_order": "step_reward", "learner.update": "standard",
    }  # fmt: skip


def test_the_params_of_a_run_are_the_overrides_of_its_point(recorded: Recorded):
    again = planned_point([f"{name}={value}" for name, value in recorded.run.data.params.items()])
    assert again.fingerprint == recorded.planned.fingerprint


@pytest.mark.parametrize("name", [*CURVES, "epsilon", "steps/q90"])
def test_a_curve_has_one_value_a_trial_from_trial_zero(name: str, recorded: Recorded):
    expected = recorded.curves.curves[name].tolist()
    assert recorded.history(name) == list(enumerate(expected))
    assert len(expected) == 100


def test_curves_have_the_values_that_their_names_say(recorded: Recorded):
    steps = recorded.curves.steps
    assert [value for _, value in recorded.history("steps/mean")] == steps.mean(axis=0).tolist()
    assert [value for _, value in recorded.history("steps/median")] == np.median(steps, axis=0).tolist()
    assert [value for _, value in recorded.history("success_rate")] == recorded.curves.success.mean(axis=0).tolist()


def test_curves_on_demand_are_no_metrics_by_default(recorded: Recorded):
    assert not {"steps/q10", "steps/over_optimum"} & set(recorded.run.data.metrics)


def test_scalars_are_metrics(recorded: Recorded):
    scalars = recorded.curves.scalars((5, 5))
    assert {name: recorded.run.data.metrics[name] for name in scalars} == scalars
    assert set(recorded.run.data.metrics) == {*scalars, *CURVES, "epsilon", "steps/q90"}
    assert all(recorded.history(name) == [(0, value)] for name, value in scalars.items())


def test_scalars_have_the_values_that_their_names_say(recorded: Recorded):
    steps, metrics = recorded.curves.steps, recorded.run.data.metrics
    totals = steps.sum(axis=1)
    assert metrics["total_steps"] == pytest.approx(totals.mean())
    assert metrics["total_steps_sem"] == pytest.approx(totals.std(ddof=1) / math.sqrt(3))
    assert metrics["total_steps_scaled"] == pytest.approx(totals.mean() * 10 / 5)
    assert metrics["failed_trials"] == pytest.approx((steps == 10_000).mean())
    final = (steps / recorded.curves.optimum[:, np.newaxis])[:, -FINAL_TRIALS:]
    assert metrics["final_steps_over_optimum"] == pytest.approx(final.mean())


def test_tags_name_the_point_the_user_and_the_code(recorded: Recorded):
    tags = recorded.run.data.tags
    assert tags["fingerprint"] == recorded.planned.fingerprint
    assert {tag for tag in tags if tag.startswith("study.")} == {"study.fig3", "study.table4"}
    assert tags["rl_design_space.version"] == rl_design_space.__version__
    assert tags["mlflow.user"] == getpass.getuser()
    assert tags["mlflow.source.type"] == "LOCAL"
    assert tags["mlflow.source.name"] == "rl-design-space"


def test_the_commit_is_a_tag_where_there_is_a_checkout(recorded: Recorded):
    checkout = CONF.parent
    if not (checkout / ".git").exists():
        assert "mlflow.source.git.commit" not in recorded.run.data.tags
        return
    commit = output_of("git", "-C", checkout, "rev-parse", "HEAD").strip()
    assert recorded.run.data.tags["mlflow.source.git.commit"] == commit


def test_the_artifacts_are_beside_the_database(recorded: Recorded, shared_database: Path):
    folder = recorded.artifact("")
    assert folder.is_relative_to(shared_database.parent / "artifacts" / "design-points")
    assert {path.name for path in folder.iterdir()} == {"periods.npz", "config.yaml", "curve.svg"}


def test_the_artifact_holds_every_trial_of_every_period(recorded: Recorded):
    with np.load(recorded.artifact("periods.npz")) as arrays:
        assert arrays["steps"].dtype == np.uint16
        np.testing.assert_array_equal(arrays["steps"], recorded.curves.steps)
        np.testing.assert_array_equal(arrays["success"], recorded.curves.success)
        np.testing.assert_array_equal(arrays["optimum"], recorded.curves.optimum)


def test_the_artifact_holds_every_curve(recorded: Recorded):
    arrays = read_saved(recorded.artifact("periods.npz"))
    assert set(arrays) == {"steps", "success", "optimum", "rows", *CURVES, *CURVES_ON_DEMAND}
    for name, curve in recorded.curves.curves.items():
        np.testing.assert_array_equal(arrays[name], curve)


def test_the_config_artifact_instantiates_to_the_point(recorded: Recorded):
    config = OmegaConf.load(recorded.artifact("config.yaml"))
    assert DesignPoint(**hydra.utils.instantiate(config, _convert_="all")) == recorded.planned.point


def test_the_config_artifact_names_its_command_and_every_value(recorded: Recorded):
    text = recorded.artifact("config.yaml").read_text(encoding="utf-8")
    assert text.splitlines()[0] == f"# {recorded.planned.command}"
    config = yaml.safe_load(text)
    assert list(config) == [field.name for field in fields(DesignPoint) if field.name != "curriculum"]
    assert config["msa"] == {
        "_target_": "rl_design_space.design.msa.MultiStepActions",
        "lengths": [2, 3],
        "propagation": "primitives",
        "reward": "realised",
        "sub_goal": "continue",
    }


def test_steps_beyond_sixteen_bits_are_kept(tmp_path: Path):
    steps = np.array([[70_000, 2**31 - 2]], dtype=np.int32)
    ones = np.ones((1, 2), np.int32)
    curves = LearningCurves(steps, np.array([[True, False]]), ones[0, :1], ones, np.array([0.1, 0.1]), 1.0)
    (tmp_path / "periods.npz").write_bytes(content.periods_file(curves))
    np.testing.assert_array_equal(read_saved(tmp_path / "periods.npz")["steps"], steps)


def test_values_that_are_not_finite_are_no_metrics():
    _, curves = learned()
    points = content.metrics(curves, {"good": 1.0, "bad": math.nan, "worse": math.inf}, ())
    assert [name for name, _, step in points if name in ("good", "bad", "worse")] == ["good"]
