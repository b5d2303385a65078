"""Claims as they are written in YAML, and their parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass as plain_dataclass
from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.analysis.parts import Part
from rl_design_space.config.build import build, construct
from rl_design_space.config.target import check_fields, class_of
from rl_design_space.errors import ConfigError
from rl_design_space.report.base import Text

_Nodes = Annotated[tuple[Any, ...], Field(strict=False)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Claim:
    """One claim.

    Attributes:
        statement: what it says.
        study: whose table or figure shows it.
        parts: what must hold, each an option of `analysis.parts`; none if there is nothing to measure. They were
            registered before anything was measured.
        later: parts that were written afterwards, for a verdict beside the registered one; `parts` if left out.
        awaits: what has to be there before more can be measured.
    """

    statement: Text
    study: Text
    parts: _Nodes
    later: _Nodes | None = None
    awaits: str = ""


@plain_dataclass(frozen=True)
class BuiltClaim:
    """A claim with the parts that its YAML describes.

    Attributes:
        claim: what it says.
        registered: parts that were written before anything was measured.
        later: parts that were written afterwards, or the registered ones.
    """

    claim: Claim
    registered: tuple[Part, ...]
    later: tuple[Part, ...]


def built_claims(nodes: Mapping[str, Mapping[str, Any]]) -> dict[str, BuiltClaim]:
    """Return claims by name, their parts built.

    Raises:
        ConfigError: a value is not allowed, or a range does not admit the paper's own numbers. Registered ranges may
            do that, because they are not changed; then the claim needs later parts.
    """
    built = {}
    for name, node in nodes.items():
        key = f"claims.{name}"
        claim = construct(Claim, node, key)
        registered = _built_parts(f"{key}.parts", claim.parts)
        later = registered if claim.later is None else _built_parts(f"{key}.later", claim.later)
        for place, part in enumerate(later):
            if refused := part.refused():
                where = "parts" if claim.later is None else "later"
                raise ConfigError(_refusal(f"{key}.{where}.{place}", part, refused, claim.later is None))
        built[name] = BuiltClaim(claim, registered, later)
    return built


def _built_parts(key: str, nodes: tuple[Any, ...]) -> tuple[Part, ...]:
    return tuple(built_part(f"{key}.{place}", node) for place, node in enumerate(nodes))


def built_part(key: str, node: Any) -> Part:
    """Build a part, with the parts that it is made of.

    Args:
        key: key of the part, for messages.
        node: an option of `analysis.parts`.

    Raises:
        ConfigError: a value is not allowed.
    """
    inner = node.get("parts") if isinstance(node, Mapping) else None
    if isinstance(inner, (list, tuple)):
        kind = class_of(key, node.get("_target_"))
        check_fields(key, kind, node)
        fields = {name: value for name, value in node.items() if name != "_target_"}
        part = construct(kind, {**fields, "parts": _built_parts(f"{key}.parts", tuple(inner))}, key)
    else:
        part = build(key, node)
    if not isinstance(part, Part):
        raise ConfigError.at(key, node, "should be an option of analysis.parts")
    return part


def _refusal(key: str, part: Part, refused: tuple[float, ...], is_registered: bool) -> str:
    numbers = ", ".join(f"{number:.3g}" for number in refused)
    remedy = "; registered parts may, if the claim has later ones" if is_registered else ""
    return f"{key}: its range should admit the paper's own {numbers} ({getattr(part, 'what', '')}){remedy}"
