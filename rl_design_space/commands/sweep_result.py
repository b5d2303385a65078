"""The result of a sweep in a few lines: the best points, which choices mattered, and the commands for more."""

from __future__ import annotations

import math
import shlex
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

from rl_design_space.plan.differences import differing

if TYPE_CHECKING:
    from rl_design_space.plan.plan import Plan
    from rl_design_space.tracking.tracker import StoredRun

#: Points above which a sweep prints no result, and points that are listed.
_MOST, _LISTED = 5000, 10
#: Choices that are named, and draws of their shares.
_NAMED, _DRAWS = 2, 200
_TIE, _STAR = "≈", "★"
_NORMAL = NormalDist()
#: What the report does otherwise, which has other shares.
_OTHER_SCALE = "; the report `importance` is of log(steps / optimum), period by period"
_TOTAL_STEPS = "total_steps"
#: Parameters that make no designs.
_REPEATED = ("seed", "task.periods")


@dataclass(frozen=True)
class _Design:
    """A design, its total steps and their standard error."""

    parameters: Mapping[str, Any]
    steps: float
    error: float
    is_best: bool = False


def result_lines(
    plan: Plan, stored: Mapping[str, StoredRun], settings: Sequence[str] = (), best: Collection[str] | None = None
) -> list[str]:
    """Return the result of a sweep, by recorded scalars alone; empty of a single design, and of very many points.

    Args:
        plan: the points of the sweep.
        stored: their runs, by fingerprint.
        settings: overrides that choose the store, for the commands.
        best: fingerprints of the points that cannot be told from the best, paired by period; None if not known.
    """
    designs = _designs(plan, stored, best or ()) if len(plan) <= _MOST else []
    if len(designs) < 2:
        return []
    names = differing([design.parameters for design in designs])
    ordered = sorted(designs, key=lambda design: design.steps)
    lines = [f"fewest total steps of {len(designs):,} designs, ± 95 % of each by itself:"]
    tied = [each.is_best for each in ordered] if best is not None else _tied(ordered)
    mark = _TIE if best is None else _STAR
    for design, is_tied in list(zip(ordered, tied, strict=True))[:_LISTED]:
        values = " ".join(f"{name}={design.parameters[name]}" for name in names if name in design.parameters)
        error = f" ± {1.96 * design.error:,.0f}" if design.error else ""
        lines.append(
            f"  {mark if is_tied and (sum(tied) > 1 or best is not None) else ' '} {design.steps:,.0f}{error}  {values}"
        )
    if best is not None:
        lines.append(f"{_STAR} {sum(tied):,} of {len(designs):,} designs cannot be told from the best at 95 %")
    elif sum(tied) > 1:
        lines.append(f"{_TIE} {sum(tied):,} designs cannot be told from the best, without pairing their periods")
    return [*lines, *_what_mattered(designs, names), *more_lines(plan, settings)]


def _tied(ordered: Sequence[_Design]) -> list[bool]:
    """Return which designs cannot be told from the first; pairing by period would tell more of them from it."""
    # All differences from the best hold together.
    width = _NORMAL.inv_cdf(1 - 0.05 / (len(ordered) - 1))
    return [each.steps - ordered[0].steps <= width * math.hypot(each.error, ordered[0].error) for each in ordered]


def mattered_lines(plan: Plan, stored: Mapping[str, StoredRun]) -> list[str]:
    """Return which choices mattered most, as a line; none if that is not known."""
    designs = _designs(plan, stored) if len(plan) <= _MOST else []
    return _what_mattered(designs, differing([design.parameters for design in designs])) if designs else []


def more_lines(plan: Plan, settings: Sequence[str], objective: str = _TOTAL_STEPS) -> list[str]:
    """Return the commands for more; none if nothing was recorded.

    Args:
        plan: the points of the sweep.
        settings: overrides that choose the store.
        objective: the measure that decided.
    """
    if "tracking=none" in settings:
        return []
    chosen = [f"--study={plan.studies[0]}"] if len(plan.studies) == 1 else []
    flags = {"best": "--value", "importance": "--scale"}
    if objective == _TOTAL_STEPS:  # which both have by themselves, one of them as a logarithm
        flags = dict.fromkeys(flags, "")
    words = ([word, *chosen, *([flag, objective] if flag else [])] for word, flag in flags.items())
    return [f"more: {shlex.join(['rl-design-report', *each, *settings])}" for each in words]


def _what_mattered(designs: Sequence[_Design], names: Sequence[str]) -> list[str]:
    mattered = _mattered(designs, names)
    return [f"mattered most for log(total steps): {mattered}{_OTHER_SCALE}"] if mattered else []


def _designs(plan: Plan, stored: Mapping[str, StoredRun], best: Collection[str] = ()) -> list[_Design]:
    """Return the designs that have a run; several seeds are averaged."""
    found: dict[Hashable, list[_Design]] = {}
    for planned in plan:
        run = stored.get(planned.fingerprint)
        if run and run.scalars.get("total_steps", 0) > 0:
            parameters = {
                name: str(value) if isinstance(value, list | tuple) else value
                for name, value in planned.parameters.items()
                if name not in _REPEATED
            }
            error = run.scalars.get("total_steps_sem", 0.0)
            design = _Design(parameters, run.scalars["total_steps"], error, planned.fingerprint in best)
            found.setdefault(tuple(parameters.items()), []).append(design)
    return [_averaged(seeds) for seeds in found.values()]


def _averaged(seeds: Sequence[_Design]) -> _Design:
    steps = sum(each.steps for each in seeds) / len(seeds)
    error = math.hypot(*(each.error for each in seeds)) / len(seeds)
    return _Design(seeds[0].parameters, steps, error, seeds[0].is_best)


def _mattered(designs: Sequence[_Design], names: Sequence[str]) -> str:
    """Return the choices with the largest shares of the variance; empty if there is one choice, or no factorial."""
    import numpy as np

    from rl_design_space.analysis.factorial import factors, grids
    from rl_design_space.analysis.importance import PAIR, Cells, decomposed
    from rl_design_space.errors import ConfigError

    parameters = [design.parameters for design in designs]
    if len(factors(parameters, names)) < 2 or not all(design.error for design in designs):
        return ""
    try:
        found = grids(parameters, names)
    except ConfigError:
        return ""
    means = np.log([design.steps for design in designs])
    errors = np.array([design.error / design.steps for design in designs])
    samples = means + errors * np.random.default_rng(0).standard_normal((_DRAWS, len(means)))
    whole = decomposed(
        [
            Cells(tuple(f.name for f in part.factors), means[part.points], samples[:, part.points])
            for part in found.parts
        ]
    )
    if whole.is_noise:
        return "nothing can be told from noise"
    shares = [each for each in whole.effects if PAIR not in each.effect][:_NAMED]
    # Noise is subtracted from both shares, and may leave less of the larger one.
    alone = [max(each.share.value, 0) for each in shares]
    return ", ".join(
        f"{each.effect} {share:.0%} (with interactions {max(each.total.value, share):.0%})"
        for each, share in zip(shares, alone, strict=True)
    )
