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
