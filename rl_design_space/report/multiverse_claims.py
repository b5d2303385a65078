"""Claims of a multiverse: their parts for every measure, statistic and set of limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass as plain_dataclass
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts import Part
from rl_design_space.config.build import build
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import Text

_LIMITS = ("low", "high")
_Texts = Annotated[tuple[Text, ...], Field(strict=False, min_length=1)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Role:
    """What a word of the claims, such as "fast", may be measured by.

    Attributes:
        measures: in their text form, e.g. `steps_after=30`; the first is the registered one.
        statistics: of the measures; the first is the registered one.
    """

    measures: _Texts
    statistics: _Texts = ("mean", "median")

    def spec(self, measure: int, statistic: int) -> str:
        """Return a measure with its statistic; the nearest there is for indices beyond the last."""
        name = self.measures[min(measure, len(self.measures) - 1)]
        of = self.statistics[min(statistic, len(self.statistics) - 1)]
        return name if of == "mean" else f"{name},statistic={of}"


@dataclass(frozen=True, kw_only=True, config=STRICT)
class MultiverseClaim:
    """A claim whose measures and limits are left open.

    Attributes:
        role: the role whose measure is varied; empty if nothing in the claim is measured.
        parts: what must hold, each an option of `analysis.parts`, with roles as measures and words as limits.
    """

    role: str = ""
    parts: Annotated[tuple[Any, ...], Field(strict=False, min_length=1)]


@plain_dataclass(frozen=True)
class Judgement:
    """A way to measure and judge a claim.

    Attributes:
        measure, statistic, threshold: indices of the choices.
        parts: the parts of the claim, as they are then.
    """

    measure: int
    statistic: int
    threshold: int
    parts: Sequence[Part]

    @property
    def place(self) -> tuple[int, int, int]:
        return self.measure, self.statistic, self.threshold


@plain_dataclass(frozen=True)
class Wording:
    """A claim under all ways to measure and judge it.

    Attributes:
        name: of the claim.
        role: whose measure is varied; empty if nothing is measured.
        measures, statistics: their names.
        judgements: one for each combination with a set of limits; fewer if sets do not differ for this claim.
        thresholds: for each set of limits, the one that stands for it: itself, or an equal one before.
    """

    name: str
    role: str
    measures: Sequence[str]
    statistics: Sequence[str]
    judgements: Sequence[Judgement]
    thresholds: Sequence[int]


def worded(
    name: str, claim: MultiverseClaim, roles: Mapping[str, Role], thresholds: Mapping[str, Mapping[str, float]]
) -> Wording:
    """Return a claim under all ways to measure and judge it.

    Args:
        name: of the claim.
        claim: the claim.
        roles: by name.
        thresholds: sets of limits by name, each by word.

    Raises:
        ConfigError: a role or a word is not known, or a part has a value that is not allowed.
    """
    if claim.role and claim.role not in roles:
        raise ConfigError.unknown(f"claims.{name}.role", claim.role, roles)
    varied = roles.get(claim.role)
    measures = varied.measures if varied else ("",)
    statistics = varied.statistics if varied else ("",)
    # Parts are built once, which takes time, and changed for each judgement.
    first = [_worded(node, roles, next(iter(thresholds.values())), name) for node in claim.parts]
    built = [build(f"claims.{name}.parts.{place}", node) for place, node in enumerate(first)]
    limits = [[_limits(node, words, name) for node in claim.parts] for words in thresholds.values()]
    standing = [limits.index(each) for each in limits]
    judgements = []
    for number, words in enumerate(thresholds.values()):
        if standing[number] == number:
            for measure, statistic in product(range(len(measures)), range(len(statistics))):
                spec = partial(_spec, roles, claim.role, measure, statistic)
                parts = [_changed(*each, words, spec) for each in zip(built, claim.parts, strict=True)]
                judgements.append(Judgement(measure, statistic, number, parts))
    return Wording(name, claim.role, measures, statistics, judgements, standing)


def _spec(roles: Mapping[str, Role], varied: str, measure: int, statistic: int, name: str) -> str:
    """Return the measure of a role; one that is not varied keeps its first. What is no role is left as it is."""
    return roles[name].spec(measure if name == varied else 0, statistic) if name in roles else ""


def _worded(node: Any, roles: Mapping[str, Role], words: Mapping[str, float], claim: str) -> Any:
    """Return a part with measures in place of roles, and numbers in place of words.

    Raises:
        ConfigError: a word is not known.
    """
    if isinstance(node, list):
        return [_worded(each, roles, words, claim) for each in node]
    found = dict(node)
    if "parts" in found:
        found["parts"] = _worded(found["parts"], roles, words, claim)
    if isinstance(role := found.get("measure"), str) and role in roles:
        found["measure"] = roles[role].spec(0, 0)
    for key in _LIMITS:
        if isinstance(word := found.get(key), str):
            if word not in words:
                raise ConfigError.unknown(f"word of claims.{claim}", word, words)
            found[key] = float(words[word])
    return found


def _limits(node: Any, words: Mapping[str, float], claim: str) -> list[Any]:
    """Return all limits of a part."""
    worded = _worded(node, {}, words, claim)
    return [worded.get(key) for key in _LIMITS] + [_limits(each, words, claim) for each in worded.get("parts", ())]


def _changed(part: Any, node: Mapping[str, Any], words: Mapping[str, float], spec: Callable[[str], str]) -> Any:
    """Return a built part with the measure and the limits of another judgement.

    Args:
        part: the part.
        node: what it was built from, with roles and words.
        words: limits by word.
        spec: the measure of a role.
    """
    if "parts" in node:
        inner = zip(part.parts, node["parts"], strict=True)
        return replace(part, parts=tuple(_changed(each, one, words, spec) for each, one in inner))
    new: dict[str, Any] = {key: float(words[node[key]]) for key in _LIMITS if isinstance(node.get(key), str)}
    if hasattr(part, "measure") and (changed := spec(node["measure"])):
        new["measure"] = changed
    return replace(part, **new) if new else part
