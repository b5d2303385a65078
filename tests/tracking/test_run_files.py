"""Damaged files of runs are recognised, whichever byte is wrong, and nothing else is called damaged."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from rl_design_space.errors import ConfigError
from rl_design_space.learning.archive import write_arrays
from rl_design_space.plan.describe import resolved_config
from rl_design_space.tracking.content import periods_file
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.record import params
from rl_design_space.tracking.run_files import (
    DamagedFileError,
    check_config,
    check_periods,
    read_config,
    read_periods,
)
from tests.points import planned_point
from tests.tracking.stores import learned

PLANNED, CURVES = learned("representation=direction", "msa=lengths_2_3", "learner.alpha=1e-5")
MESSAGE = r"run abc: periods\.npz is damaged \(.+\); .*`rl-design-space store forget abc`.*"
RUN = FoundRun("abc", "", 0, 0, "", {**params(PLANNED.parameters), "world.source": "version 1"}, CURVES.scalars())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder of a run's files, as MLflow lays them out."""
    place = tmp_path / "experiment" / "abc" / "artifacts"
    place.mkdir(parents=True)
    return place


def is_damaged(path: Path) -> bool:
    """Return whether a file is called damaged; if it is not, its arrays are what was recorded."""
    try:
        arrays = read_periods("abc", path)
        check_periods(RUN, arrays)
    except DamagedFileError as error:
        return bool(re.fullmatch(MESSAGE, str(error)))
    for name in ("steps", "success", "optimum", "rows"):
        assert np.array_equal(arrays[name], getattr(CURVES, name))
    return False


def test_files_as_they_are_recorded_are_not_damaged(folder: Path):
    for keep in ("periods", "curves"):
        path = folder / "periods.npz"
        path.write_bytes(periods_file(CURVES, keep))
        check_periods(RUN, read_periods("abc", path))
    path = folder / "config.yaml"
    path.write_text(yaml.safe_dump(resolved_config(PLANNED.point)))
    check_config(RUN, read_config("abc", path))


@pytest.mark.parametrize(
    "overrides",
    [
        ("curriculum=new_goals", "curriculum.layouts=2"),
        ("curriculum=refine", "representation=aggregated", "curriculum.trials=2"),
    ],
    ids=["new_goals", "refine"],
)
def test_the_trials_of_all_stages_are_expected(overrides: tuple[str, ...], folder: Path):
    planned, curves = learned(*overrides)
    run = FoundRun("abc", "", 0, 0, "", params(planned.parameters), curves.scalars())
    path = folder / "periods.npz"
    path.write_bytes(periods_file(curves))
    arrays = read_periods("abc", path)
    check_periods(run, arrays)
    with pytest.raises(DamagedFileError, match="trials, not 3 × "):
        check_periods(run, {**arrays, "stages:trials": arrays["stages:trials"] + 1})
    with pytest.raises(DamagedFileError, match="it lacks its stages"):
        check_periods(run, {name: array for name, array in arrays.items() if not name.startswith("stages:")})


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"stages:carried": None}, "it lacks stages:carried"),
        ({"stages:trials": None, "stages:side": None}, "it lacks stages:trials"),
        ({"stages:rows": np.zeros((2, 2, 2))}, "its stages:rows does not fit its stages"),
        ({"stages:trials": np.array([6, 7])}, "its stages:trials does not fit its steps"),
    ],
)
def test_arrays_of_stages_that_are_lost_or_do_not_fit_are_named(changed: dict, reason: str, folder: Path):
    _, curves = learned("curriculum=new_goals", "curriculum.layouts=2")
    path = folder / "periods.npz"
    path.write_bytes(periods_file(curves))
    arrays = {**read_periods("abc", path), **changed}
    write_arrays(path, {name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(DamagedFileError, match=re.escape(f"({reason})")):
        read_periods("abc", path)


STAGES = [
    {"task.trials": 2, "refine": {"split": "all", "rows": None}},
    {"task.trials": 4, "exploration": {"_target_": "rl_design_space.design.exploration.Constant", "epsilon": 0.0}},
]
NESTED = {
    "representation": {
        "_target_": "mine.Both",
        "of": {"_target_": "rl_design_space.design.Without", "of": {"_target_": "mine.Own", "width": 2}},
        "also": [{"_target_": "mine.Own", "width": 3}, {"_target_": "mine.Own", "width": 4}],
        "table": {"a": [1, 2]},
        "tables": [{"a": 1}],
    },
    "curriculum": {"_target_": "rl_design_space.design.Stages", "stages": STAGES},
}
#: As they have been recorded of such components.
NESTED_PARAMS = {
    "representation": "both",
    "representation.of": "Without",
    "representation.of.of": "mine.Own",
    "representation.of.of.width": "2",
    "representation.also": "[Own(width=3), Own(width=4)]",
    "representation.table": "{'a': [1, 2]}",
    "representation.tables": "[{'a': 1}]",
    "curriculum.stages": "[{task.trials: 2, refine: {split: all, rows: null}}, "
    "{task.trials: 4, exploration: Constant(epsilon=0.0)}]",
}


def test_components_and_mappings_in_components_are_compared_by_value():
    run = FoundRun("abc", "", 0, 0, "", NESTED_PARAMS, {})
    check_config(run, NESTED)
    sorted_again = [dict(sorted(stage.items())) for stage in STAGES]
    check_config(run, {**NESTED, "curriculum": {"stages": sorted_again}})
    other = {**NESTED, "curriculum": {"stages": [{**STAGES[0], "task.trials": 3}, STAGES[1]]}}
    with pytest.raises(DamagedFileError, match=r"it says curriculum\.stages=\[\{task\.trials: 3, .*was \[\{task"):
        check_config(run, other)
    inner = {**NESTED["representation"], "of": {"_target_": "mine.Without"}}
    with pytest.raises(DamagedFileError, match=r"it says representation\.of=mine\.Without, recorded was Without"):
        check_config(run, {**NESTED, "representation": inner})


@pytest.mark.parametrize(
    "overrides",
    [
        ("representation=without", "representation.leave_out=[goal1]"),
        ("msa=none", "curriculum=coarse_to_fine", "world.size=10"),
    ],
    ids=["without", "coarse_to_fine"],
)
def test_params_agree_with_the_config_of_their_point(overrides: tuple[str, ...]):
    planned = planned_point(overrides)
    config = yaml.safe_load(yaml.safe_dump(resolved_config(planned.point)))
    check_config(FoundRun("abc", "", 0, 0, "", params(planned.parameters), {}), config)


def test_a_file_that_is_cut_short_anywhere_is_damaged(folder: Path):
    whole = periods_file(CURVES)
    path = folder / "periods.npz"
    for length in range(0, len(whole), 37):
        path.write_bytes(whole[:length])
        assert is_damaged(path), length


def test_a_changed_byte_is_noticed_or_makes_no_difference(folder: Path):
    whole = periods_file(CURVES)
    path = folder / "periods.npz"
    rng = np.random.default_rng(0)
    damaged = 0
    for place in range(0, len(whole), 13):
        changed = bytearray(whole)
        changed[place] ^= int(rng.integers(1, 256))
        path.write_bytes(changed)
        damaged += is_damaged(path)
    assert damaged > 0.4 * len(whole) / 13


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"optimum": None}, "it lacks optimum"),
        ({"success": CURVES.success[:1]}, "its success does not fit its steps"),
        ({"steps": CURVES.steps[0]}, "its steps are not those of periods and trials"),
        ({"steps": None}, "it holds no learning curve"),
        ({"steps": CURVES.steps + 1}, "its total_steps is .*, recorded was "),
        ({"success": ~CURVES.success}, "its failed_.* is .*, recorded was "),
    ],
    ids=str,
)
def test_arrays_of_another_result_are_damaged(change: dict, reason: str, folder: Path):
    arrays = {name: getattr(CURVES, name) for name in ("steps", "success", "optimum", "rows", "epsilon")} | change
    write_arrays(folder / "periods.npz", {name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(DamagedFileError, match=reason):
        check_periods(RUN, read_periods("abc", folder / "periods.npz"))


def test_fewer_periods_than_were_recorded_are_damaged(folder: Path):
    _, other = learned("task.periods=2")
    (folder / "periods.npz").write_bytes(periods_file(other))
    with pytest.raises(DamagedFileError, match="it holds 2 × 4 trials, not 3 × 4"):
        check_periods(RUN, read_periods("abc", folder / "periods.npz"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "it holds no mapping"),
        ("[1, 2", "while parsing a flow"),
        ("a: \0", "unacceptable character"),
        (yaml.safe_dump({**resolved_config(PLANNED.point), "seed": 7}), "it says seed=7, recorded was 0"),
        (yaml.safe_dump({**resolved_config(PLANNED.point), "world": {}}), r"it lacks world\.size"),
    ],
    ids=["empty", "cut", "control character", "changed", "a part missing"],
)
def test_a_config_that_is_not_what_was_recorded_is_damaged(text: str, reason: str, folder: Path):
    (folder / "config.yaml").write_text(text)
    with pytest.raises(DamagedFileError, match=rf"run abc: config\.yaml is damaged \({reason}"):
        check_config(RUN, read_config("abc", folder / "config.yaml"))


def test_a_missing_file_is_damage_and_a_missing_disk_is_not(folder: Path, tmp_path: Path):
    with pytest.raises(DamagedFileError, match="there is no"):
        read_periods("abc", folder / "periods.npz")
    with pytest.raises(ConfigError, match="run abc: its files are not on this machine: there is no") as caught:
        read_config("abc", tmp_path / "moved" / "abc" / "artifacts" / "config.yaml")
    assert not isinstance(caught.value, DamagedFileError)
