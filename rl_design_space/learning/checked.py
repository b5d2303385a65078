"""Tables of the components of a design point, validated because compiled code does not check its indices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray, IntArray
from rl_design_space.design import (
    WAIT,
    Behaviour,
    CarryRule,
    DesignPoint,
    MultiStepActions,
    PortableRepresentation,
    Scene,
    cell_count,
    level_of,
    open_cells,
)
from rl_design_space.design.identity import full_name, function_name
from rl_design_space.errors import ConfigError
from rl_design_space.learning.checked_dynamics import by_transition as by_transition
from rl_design_space.learning.checked_dynamics import outcomes as outcomes
from rl_design_space.learning.checked_dynamics import potential as potential
from rl_design_space.learning.checked_dynamics import transitions as transitions
from rl_design_space.learning.checked_table import LARGEST, LARGEST_CODE, checked_table
from rl_design_space.learning.controls import STOP, ActionTable

_LONGEST = 1_000_000


def places(point: DesignPoint) -> NDArray[np.int32]:
    """Return the cells on which starts and goals lie: (k,) int32, ascending.

    Raises:
        ConfigError: the world returns an array of the wrong shape, type or range, or too few cells.
    """
    world, cells, name = point.world, open_cells(point.world), full_name(type(point.world))
    shape = cells.shape if isinstance(cells, np.ndarray) and cells.ndim == 1 else (cell_count(world),)
    checked_table("world", world, "open_cells", cells, shape, np.int32, 0, cell_count(world) - 1)
    if not (np.diff(cells) > 0).all():
        raise ConfigError(f"world: {name}.open_cells() should give each cell once, in ascending order")
    if len(cells) <= point.task.goals:
        raise ConfigError(
            f"task.goals={point.task.goals}: start and goals lie on different cells, "
            f"and {name} has only {len(cells)} open ones"
        )
    return cells


def epsilons(point: DesignPoint) -> FloatArray:
    """Return the exploration schedule: (trials,) float64, probability of exploring, or another level.

    Raises:
        ConfigError: the schedule is of the wrong length, type or range.
    """
    trials = point.task.trials
    schedule = point.exploration.schedule(trials)
    low, high = {"epsilon": (0, 1), "temperature": (1e-6, 1e6), "bonus": (0, 1e6)}[level_of(point.exploration)]
    return checked_table("exploration", point.exploration, "schedule", schedule, (trials,), np.float64, low, high)


def rewards(point: DesignPoint) -> FloatArray:
    """Return the rewards: (3,) float64, for a step, for the due sub-goal, for the due final goal.

    Raises:
        ConfigError: the table is of the wrong shape, type or range.
    """
    return checked_table("reward", point.reward, "table", point.reward.table(), (3,), np.float64, -LARGEST, LARGEST)


def limits(point: DesignPoint) -> NDArray[np.int32]:
    """Return the most steps of each action: (n_actions,) int32.

    Raises:
        ConfigError: the limits are of the wrong number, type or range.
    """
    msa = point.msa
    if isinstance(msa, MultiStepActions):
        _check_lengths(msa)
    return checked_table("msa", msa, "limits", msa.limits(), (msa.n_actions,), np.int32, 1, _LONGEST)


def _check_lengths(msa: MultiStepActions) -> None:
    table = checked_table(
        "msa", msa, "action_lengths", msa.action_lengths(), (1 + len(msa.lengths),), np.int32, 1, _LONGEST
    )
    if table[0] != 1 or len(np.unique(table)) != len(table):
        raise ConfigError(
            f"msa: {full_name(type(msa))}.action_lengths() should begin with 1 and hold every length once"
        )


def action_table(point: DesignPoint, goals: IntArray, codes: NDArray[np.int64]) -> ActionTable | None:
    """Return what the actions do in several periods; None if they only repeat steps.

    Args:
        point: the design point.
        goals: (periods, n_goals) cells.
        codes: (periods, n_goals, cells) observation codes.

    Raises:
        ConfigError: the actions return tables of the wrong shape, type or range.
    """
    if point.msa.repeats:
        return None
    steps, stops, marks = behaviour_of(point, goals, codes)
    # Copied, so that arrays are of one type for the compiler, whether they can be written or not.
    marks = np.zeros(codes.shape, dtype=np.int64) if marks is None else marks.copy(order="C")
    controls = steps.astype(np.uint8) | stops * np.uint8(STOP)
    controls = np.ascontiguousarray(np.moveaxis(controls, 0, -1))
    return ActionTable(controls.reshape(len(codes), -1, len(steps)), marks.reshape(len(codes), -1))


def behaviour_of(point: DesignPoint, goals: IntArray, codes: NDArray[np.int64]) -> Behaviour:
    """Return what the actions do in several periods, whether they only repeat steps or not.

    Args:
        point: the design point.
        goals: (periods, n_goals) cells.
        codes: (periods, n_goals, cells) observation codes.

    Raises:
        ConfigError: the actions return tables of the wrong shape, type or range.
    """
    msa = point.msa
    found = msa.behaviour(point.world, point.representation, goals, codes)
    by_action = (msa.n_actions, *codes.shape)
    checked_table("msa", msa, "behaviour", found.steps, by_action, np.int8, 0, WAIT)
    checked_table("msa", msa, "behaviour", found.stops, by_action, np.bool_, 0, 1)
    if found.marks is not None:
        checked_table("msa", msa, "behaviour", found.marks, codes.shape, np.int64, 0, LARGEST_CODE)
    return found


def observation_codes(point: DesignPoint, goals: IntArray) -> NDArray[np.int64]:
    """Return the observations of the agent in several periods.

    Args:
        point: the design point.
        goals: (periods, n_goals) cells.

    Returns:
        (periods, n_goals, cells) int64 codes, contiguous, by success counter and cell.

    Raises:
        ConfigError: the representation returns codes of the wrong shape, type or range, or encodes digits that the base
            has no room for.
    """
    return _codes(point, goals, "observation")


def portable_codes(point: DesignPoint, goals: IntArray) -> NDArray[np.int64]:
    """Return the observations of the agent, as `observation_codes` does, by codes that mean the same in every world.

    Raises:
        ConfigError: the representation returns codes of the wrong shape, type or range, or encodes digits that the base
            has no room for.
    """
    return _codes(
        point, goals, "portable" if isinstance(point.representation, PortableRepresentation) else "observation"
    )


def _codes(point: DesignPoint, goals: IntArray, method: str) -> NDArray[np.int64]:
    representation, shape = point.representation, (*goals.shape, cell_count(point.world))
    try:
        codes = getattr(representation, method)(point.world, goals)
    except ConfigError as error:
        name = full_name(type(representation))
        raise ConfigError(f"representation: {name}.{method}() calls {error}") from error
    checked_table("representation", representation, method, codes, shape, np.int64, 0, LARGEST_CODE)
    # Writable, too: the kernel would be compiled once more for arrays that are not.
    return np.require(codes, requirements=["C", "W"])


def ancestors(rule: CarryRule, before: Scene, after: Scene) -> NDArray[np.int64]:
    """Return the ancestors that a user's carry rule gives: (periods, n_goals, cells) int64, contiguous.

    Raises:
        ConfigError: the function returns an array of the wrong shape, type or range.
    """
    found, states = rule(before, after), before.codes[0].size
    wanted = f"carry: {function_name(rule)}() should give whole numbers of shape {after.codes.shape}"
    if not isinstance(found, np.ndarray) or found.shape != after.codes.shape or found.dtype.kind not in "iu":
        told = f"{found.dtype} of shape {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
        raise ConfigError(f"{wanted}, not {told}")
    if found.size and (found.min() < -1 or found.max() >= states):
        raise ConfigError(f"{wanted}, all from -1 to {states - 1}; it gives {found.min()} to {found.max()}")
    return np.ascontiguousarray(found, dtype=np.int64)
