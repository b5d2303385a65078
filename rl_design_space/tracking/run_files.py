"""The files of a run, and whether they still are what was recorded."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from numpy.typing import NDArray

from rl_design_space.config.yaml_limits import check_limits, read_text
from rl_design_space.errors import ConfigError
from rl_design_space.learning.result import LearningCurves, read_saved
from rl_design_space.learning.stage_record import misfit, of_file
from rl_design_space.plan.describe import config_parameters, config_text
from rl_design_space.tracking.content import CONFIG_FILE, PERIODS_FILE
from rl_design_space.tracking.found_run import FoundRun
from rl_design_space.tracking.selection import SOURCE
from rl_design_space.tracking.values import param

#: Scalars that follow from the periods of a run alone.
_FROM_PERIODS = ("total_steps", "failed_trials", "failed_periods", "final_steps_over_optimum")
#: Scalars are recorded as they were computed; other versions of NumPy may sum in another order.
_TOLERANCE = 1e-9


class DamagedFileError(ConfigError):
    """A file of a run cannot be read, or is not what was recorded."""

    def __init__(self, run_id: str, file: str, reason: str) -> None:
        super().__init__(
            f"run {run_id}: {file} is damaged ({reason}); to learn its point anew: "
            f"`rl-design-space store forget {run_id}`, then the command that ran it"
        )
        self.run_id, self.file, self.reason = run_id, file, reason


def read_periods(run_id: str, path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a run.

    Raises:
        DamagedFileError: the file is not there, cannot be read, or its arrays do not fit together.
    """
    try:
        with path.open("rb") as file:  # NumPy leaves a file open that is none of its own
            arrays = read_saved(file)
    except Exception as error:  # zipfile, zlib and NumPy raise a dozen kinds, depending on which byte is wrong
        raise _as_damage(run_id, path, error) from error
    if problem := _misfit(arrays):
        raise DamagedFileError(run_id, PERIODS_FILE, problem)
    return arrays


def read_config(run_id: str, path: Path) -> dict[str, Any]:
    """Return the resolved config of a run, which anyone with write access to the store may have written.

    Raises:
        DamagedFileError: the file is not there, or does not hold a mapping in YAML.
    """
    try:
        text = read_text(path)
        check_limits(text, path.name)
        config = yaml.safe_load(text)
    except (OSError, ValueError, yaml.YAMLError) as error:  # ValueError: too large, or a date such as 2020-99-99
        raise _as_damage(run_id, path, error) from error
    if not isinstance(config, dict) or not config:
        raise DamagedFileError(run_id, CONFIG_FILE, "it holds no mapping of keys to values")
    return config


def check_periods(run: FoundRun, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check that the arrays of a run are those that its scalars were computed from.

    Raises:
        DamagedFileError: they are not.
    """
    if "steps" in arrays:
        if "curriculum" in run.params and not of_file(arrays):
            raise DamagedFileError(run.run_id, PERIODS_FILE, "it lacks its stages")
        periods, trials = (int(run.params.get(f"task.{name}", -1)) for name in ("periods", "trials"))
        shape = (periods, sum(stage.trials for stage in of_file(arrays)) or trials)
        if arrays["steps"].shape != shape:
            found = " × ".join(map(str, arrays["steps"].shape))
            raise DamagedFileError(run.run_id, PERIODS_FILE, f"it holds {found} trials, not {shape[0]} × {shape[1]}")
        found_scalars = LearningCurves.of_arrays(arrays).scalars()
    else:
        found_scalars = {"total_steps": float(arrays["steps/mean"].sum())}
    for name in _FROM_PERIODS:
        recorded = run.metrics.get(name)
        if recorded is not None and not math.isclose(
            found_scalars.get(name, recorded), recorded, rel_tol=_TOLERANCE, abs_tol=_TOLERANCE
        ):
            reason = f"its {name} is {found_scalars[name]:.10g}, recorded was {recorded:.10g}"
            raise DamagedFileError(run.run_id, PERIODS_FILE, reason)


def check_config(run: FoundRun, config: Mapping[str, Any]) -> None:
    """Check that the config of a run has the values of its params.

    Raises:
        DamagedFileError: it has another one.
    """
    found = config_parameters(config)
    for name, value in found.items():
        # Stages are recorded as they are typed, other mappings (in components of a user) as Python has them.
        if name in run.params and not _is_recorded(value, run.params[name]):
            reason = f"it says {name}={param(config_text(value))}, recorded was {run.params[name]}"
            raise DamagedFileError(run.run_id, CONFIG_FILE, reason)
    # Params hold the names of options, too, and the code of components; a config does not.
    values = [name for name in run.params if "." in name and not name.endswith(SOURCE)]
    if missing := [name for name in values if name not in found]:
        raise DamagedFileError(run.run_id, CONFIG_FILE, f"it lacks {missing[0]}")


def _is_recorded(value: Any, text: str) -> bool:
    """Return whether the value of a config is the recorded one; the order of the keys of a stage does not matter."""
    if text in (param(value), found := param(config_text(value))):
        return True
    try:
        return isinstance(value, list) and bool(yaml.safe_load(found) == yaml.safe_load(text))
    except yaml.YAMLError:
        return False


def _misfit(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return which array is missing or has a wrong shape; empty if all fit together."""
    if "steps" not in arrays:
        return "" if "steps/mean" in arrays else "it holds no learning curve"
    if arrays["steps"].ndim != 2 or not arrays["steps"].size:
        return "its steps are not those of periods and trials"
    periods, trials = arrays["steps"].shape
    shapes = {"success": (periods, trials), "optimum": (periods,), "rows": (periods, 2), "epsilon": (trials,)}
    for name, shape in shapes.items():
        if name not in arrays:
            return f"it lacks {name}"
        if arrays[name].shape != shape:
            return f"its {name} does not fit its steps"
    return misfit(arrays, periods, trials)


def _as_damage(run_id: str, path: Path, error: Exception) -> ConfigError:
    """Return what to report of a file that cannot be read."""
    if isinstance(error, FileNotFoundError):
        of_experiment = path.parents[2]
        if not of_experiment.exists():  # nothing is damaged: a disk is not mounted, or the folder was moved
            return ConfigError(f"run {run_id}: its files are not on this machine: there is no {of_experiment}")
        return DamagedFileError(run_id, path.name, f"there is no {path}")
    lines = str(error).strip().splitlines()
    return DamagedFileError(run_id, path.name, lines[0] if lines else type(error).__name__)
