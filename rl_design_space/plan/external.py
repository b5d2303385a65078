"""Design points whose results were measured elsewhere, by a learner that is not part of this package."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from rl_design_space._yaml import as_yaml
from rl_design_space.design import Constant, QLearning
from rl_design_space.errors import ConfigError
from rl_design_space.plan.fingerprint import fingerprint
from rl_design_space.plan.plan import PlannedPoint

#: What an external learner replaces; of these choices of the point, only the rewards that `learner` decides count.
_REPLACED = ("learner", "exploration")
_KEPT = "out_of_order"


@dataclass(frozen=True)
class ExternalPoint(PlannedPoint):
    """A design point as an external learner met it.

    Its learner and its exploration are those of a program of the user's: what is known of them are the choices. Its
    identity follows from the rest of the point, the name of the learner and the choices.

    Attributes:
        learner: name of the external learner.
        choices: its parameters, by names such as `learner.hidden` and `exploration.fraction`.
    """

    learner: str = ""
    choices: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of_planned(cls, planned: PlannedPoint, learner: str, choices: Mapping[str, Any]) -> ExternalPoint:
        """Return a planned point with another learner.

        Raises:
            ConfigError: a name of a choice is not allowed, or a value is not plain.
        """
        for name, value in choices.items():
            if name.partition(".")[0] not in _REPLACED or name == "learner" or name == f"learner.{_KEPT}":
                expected = "the choices of a learner begin with learner., those of its exploration with exploration"
                raise ConfigError(f"choices: {name}: {expected}")
            if not isinstance(value, (str, int, float, bool, tuple, list)) and value is not None:
                raise ConfigError.at(f"choices: {name}", value, "should be a plain value")
        point = planned.point
        neutral = replace(point, exploration=Constant(), learner=QLearning(out_of_order=point.learner.out_of_order))
        content = {"of": fingerprint(neutral), "learner": learner, "choices": dict(choices)}
        identity = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
        shared = {each.name: getattr(planned, each.name) for each in fields(PlannedPoint)}
        return cls(**{**shared, "fingerprint": identity}, learner=learner, choices=dict(choices))

    @property
    def parameters(self) -> dict[str, Any]:
        """The choices of the point that count, and those of the learner."""
        kept = {name: value for name, value in super().parameters.items() if not _is_replaced(name)}
        return {**kept, "learner": self.learner, **self.choices}

    @property
    def config(self) -> dict[str, Any]:
        """The point with what is known of its learner, which nothing can be built from."""
        known: dict[str, dict[str, Any]] = {"learner": {_KEPT: self.point.learner.out_of_order}}
        for name, value in self.choices.items():
            group, _, rest = name.partition(".")
            known.setdefault(group, {})[rest or "name"] = value
        return {**{name: node for name, node in super().config.items() if name not in _REPLACED}, **known}

    @property
    def measured_by(self) -> str:
        """The name of the learner."""
        return self.learner

    @property
    def name(self) -> str:
        """The learner, its choices, and the overrides of the point that count."""
        given = [override for override in self.overrides if not _is_replaced(override.partition("=")[0])]
        choices = [f"{name}={as_yaml(value)}" for name, value in self.choices.items()]
        return " ".join([f"learner={self.learner}", *choices, *given])

    @property
    def command(self) -> str:
        """What recorded it: there is no command that measures it again."""
        return f"rl_design_space.record(…, learner={self.learner!r})"


def _is_replaced(name: str) -> bool:
    return name.partition(".")[0] in _REPLACED and name != f"learner.{_KEPT}"
