"""The fingerprint of a design point: a digest of everything that determines its results."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass, replace
from types import FunctionType
from typing import Any

from rl_design_space.design import DesignPoint, Stages, stages_of
from rl_design_space.design.identity import ABSENT_AS, is_shipped
from rl_design_space.errors import ConfigError
from rl_design_space.learning.version import KERNEL_VERSION
from rl_design_space.plan.code_identity import code_identity


def fingerprint(point: DesignPoint) -> str:
    """Return SHA-256 over everything that determines a point's learning curves, as 64 hexadecimal digits.

    Option names, tracking, paths and thread counts do not contribute: `reward=many_rewards reward.step=0` is the same
    point as `reward=each_success`. Neither do fields that were added to an option later, while they have the value that
    stands for their absence, see `design.identity.absent_as`. The code of user components contributes, see
    `plan.code_identity.code_identity`. Of a curriculum, its stages contribute, in whatever way they were described.

    Raises:
        ConfigError: a field of an option is not a plain value, or a user component has no source.
    """
    return _digest(_point(point))


def fingerprints_by_periods(point: DesignPoint, periods: Iterable[int]) -> dict[str, int]:
    """Return numbers of periods by the fingerprint of the same point with exactly so many."""
    content, found = _point(replace(point, task=point.task.with_periods(1))), {}
    for number in periods:
        for part in (content["point"], *(stage["point"] for stage in content.get("stages", ()))):
            part["task"]["periods"] = number
        found[_digest(content)] = number
    return found


def _point(point: DesignPoint) -> dict[str, Any]:
    """Return what determines the results of a point: its values, and its stages if it has several."""
    stages = [
        {"point": _content(stage.point), "layout": stage.layout, "carry": _content(stage.carry)}
        | ({"refine": _content(stage.refine)} if stage.refine else {})
        for stage in stages_of(point)
    ]
    alone = point if point.curriculum == Stages() else replace(point, curriculum=Stages())
    return {"point": _content(alone), **({"stages": stages} if stages else {})}


def _digest(point: dict[str, Any]) -> str:
    content = {"kernel": KERNEL_VERSION, **point}
    try:
        canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ConfigError(f"a field of an option should be a plain value, or a list of them: {error}") from error
    return hashlib.sha256(canonical.encode()).hexdigest()


def _content(value: Any) -> Any:
    if is_dataclass(value):
        return {**_kind(type(value)), **dict(_fields(value))}
    if isinstance(value, (list, tuple)):
        return [_content(item) for item in value]
    if isinstance(value, FunctionType):
        return _kind(value)
    return value + 0.0 if isinstance(value, float) else value  # 0.0 for -0.0


def _kind(kind: type | FunctionType) -> dict[str, str]:
    """Return the identity of a class or function; the keys are Python keywords, which no field can be named."""
    if is_shipped(kind):
        return {"is": kind.__qualname__}
    return {"is": f"{kind.__module__}:{kind.__qualname__}", "from": code_identity(kind)}


def _fields(option: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(option):
        content = _content(getattr(option, field.name))
        if ABSENT_AS not in field.metadata or content != _content(field.metadata[ABSENT_AS]):
            yield field.name, content
