"""Stages: parts of a period that differ in world, layout or anything else, and share one Q-matrix."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from types import FunctionType
from typing import Annotated, Any, Literal, TypeVar, get_args

from pydantic import BeforeValidator, Field, ValidationError
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._arrays import IntArray
from rl_design_space._strict import STRICT
from rl_design_space.design.world import World
from rl_design_space.errors import ConfigError

Value = TypeVar("Value")

#: Where start and goals of a stage lie, see `Stage`.
Layout = Literal["same", "scaled", "new", "shifted"]
#: The shipped carry rules, see `Stage`.
CarryName = Literal["same_observation", "same_place", "none"]
#: Keys of a stage that are not choices.
_OWN_KEYS = ("layout", "carry", "refine")
#: Choices that all stages of a period share.
_SHARED = ("seed", "curriculum", "task", *(f"task.{name}" for name in ("goals", "periods", "periods_at_most")))


class Scene(Protocol):
    """What a carry rule knows of a stage, for several periods at a time."""

    @property
    def world(self) -> World:
        """Where the agent moves."""
        ...

    @property
    def goals(self) -> IntArray:
        """Goals of each period, (periods, n_goals) cell numbers."""
        ...

    @property
    def codes(self) -> IntArray:
        """Observation codes of each period, (periods, n_goals, cells), by success counter and cell."""
        ...


@runtime_checkable
class CarryRule(Protocol):
    """A function that says where the Q-values of a stage come from."""

    def __call__(self, before: Scene, after: Scene) -> IntArray:
        """Return the ancestor of each state of a stage, among the states of the stage before it.

        States are numbered by success counter and cell: number = counter · cells + cell.

        Args:
            before: the stage before.
            after: the stage that begins.

        Returns:
            (periods, n_goals, cells) whole numbers: the ancestor of each state, -1 where it has none. An observation
            takes the mean of the values of its states' ancestors.
        """
        ...


def _carry(rule: Any) -> Any:
    if not isinstance(rule, FunctionType) and rule not in get_args(CarryName):
        raise ValueError("should be same_observation, same_place, none, or a function of two scenes")
    return rule


#: What a Q-matrix begins with, see `Stage`.
Carry = Annotated[CarryName | CarryRule, BeforeValidator(_carry, json_schema_input_type=CarryName | str)]


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Refinement:
    """How the blocks of the stage before are split as a stage begins (docs/decisions/0035-refined-blocks.md).

    A block is a rectangle of cells at one success counter, and a row of the Q-matrix. It is split in the middle of each
    side of several cells, of odd ones after the middle cell: into two or four parts, each as a block of its own.

    Attributes:
        split: which blocks are split, each once: `disagreeing`, those whose cells disagree by the TD errors of the
            stage before, the most first; `all`, in the order of their rows; `none`, they stay as they are.
        rows: most rows of a Q-matrix; a block whose parts would be too many is not split. Any number, if None.
    """

    split: Literal["disagreeing", "all", "none"] = "disagreeing"
    rows: Annotated[int, Field(ge=1)] | None = None


def _refinement(value: Any) -> Any:
    """Convert the forms of YAML: `all`, or `{split: all, rows: 100}`."""
    if isinstance(value, str):
        return Refinement(split=value)  # type: ignore[arg-type]
    if value is not None and not isinstance(value, Mapping | Refinement):
        raise ValueError("should be disagreeing, all, none, or a mapping such as {split: all, rows: 100}")
    if not isinstance(value, Mapping):
        return value
    known = [field.name for field in fields(Refinement)]
    for key in value:
        if key not in known:
            raise ConfigError.unknown("key", key, known)
    return Refinement(**value)


def _canonical(changes: Any) -> Any:
    """Return changes in the order of their keys, each key once; values of an option that is also given are put in."""
    if not isinstance(changes, (Mapping, tuple)):
        raise ValueError("should map dotted keys to values, as {'world.size': 10} does")
    pairs = dict(changes)
    for key in pairs:
        if not isinstance(key, str):
            raise ValueError(f"{key}: no such key; should be a dotted one, such as world.size")
        if key in _SHARED or key.startswith(("curriculum.", "task.precision")):
            raise ValueError(f"{key}: all stages of a period share it; a stage may differ in anything else")
    found: dict[str, Any] = {}
    for key in sorted(pairs):
        value = _as_value(pairs[key])
        option = next((other for other in found if key.startswith(f"{other}.")), None)
        if option:
            found[option] = put(found[option], key[len(option) + 1 :].split("."), value, key)
        else:
            found[key] = value
    return tuple(found.items())


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Stage:
    """A part of a period, described by what is different from the point.

    Attributes:
        changes: values by dotted key, as {"world.size": 10, "exploration": Constant(epsilon=0)}; in YAML they stand
            beside the keys below, and options may be named. Seed, goals and periods are those of the point.
        layout: where start and goals lie: `same` as in the stage before, at first those of the point; `scaled`, the
            same places on a grid of another size; `new`, drawn afresh; `shifted`, all by one random offset, round the
            border.
        carry: what the Q-matrix begins with: `same_observation`, equal observations keep their values; `same_place`,
            a cell takes the values of the cell at the same place of the grid before; `none`, nothing is carried; or a
            function, see `CarryRule`. What has no ancestor begins with `learner.initial_q`.
        refine: how the blocks of the stage before are split, which this stage observes; None if it observes what its
            representation says. Needs the representation `Aggregated`, and another carry rule than `same_observation`.
    """

    changes: Annotated[
        tuple[tuple[str, Any], ...], BeforeValidator(_canonical, json_schema_input_type=dict[str, Any])
    ] = ()
    layout: Layout = "same"
    carry: Carry = "same_observation"
    refine: Annotated[
        Refinement | None, BeforeValidator(_refinement, json_schema_input_type=Refinement | str | None)
    ] = None

    @classmethod
    def of(cls, node: Mapping[str, Any]) -> Stage:
        """Return the stage that a mapping describes, as in YAML: dotted keys beside `layout`, `carry`, `refine`.

        Raises:
            ValueError: a key or its value is not allowed.
        """
        own = {key: node[key] for key in _OWN_KEYS if key in node}
        changes: Any = {key: node[key] for key in node if key not in _OWN_KEYS}
        return _validated(lambda: cls(changes=changes, **own), own, "")

    def as_node(self) -> dict[str, Any]:
        """Return the mapping that describes the stage, without what is the default."""
        own = {key: getattr(self, key) for key in _OWN_KEYS}
        if self.refine:
            own["refine"] = {field.name: getattr(self.refine, field.name) for field in fields(self.refine)}
        return dict(self.changes) | {key: value for key, value in own.items() if value != getattr(Stage, key)}

    def applied(self, point: Value) -> Value:
        """Return a point with the changes of this stage.

        Raises:
            ValueError: the point has no such key, or the value is not allowed.
        """
        changed: dict[str, Any] = {}
        for key, value in self.changes:
            name, *path = key.split(".")
            _check_field(point, name, "")
            changed[name] = put(changed.get(name, getattr(point, name)), path, value, key) if path else value
        # All at once: a block and the world that it fits are changed together.
        return _replaced(point, changed, "")


def put(owner: Value, path: Sequence[str], value: Any, key: str) -> Value:
    """Return a dataclass with another value at a path of fields.

    Args:
        owner: the dataclass.
        path: names of fields, one inside the other.
        value: the new value.
        key: the whole dotted key, for messages.

    Raises:
        ValueError: there is no such field, or the value is not allowed.
    """
    name, *rest = path
    prefix = key[: len(key) - len(".".join(path))]
    _check_field(owner, name, prefix)
    if rest:
        value = put(getattr(owner, name), rest, value, key)
    return _replaced(owner, {name: value}, prefix)


def _check_field(owner: Any, name: str, prefix: str) -> None:
    known = [field.name for field in fields(owner) if field.init] if is_dataclass(owner) else []
    if name not in known or isinstance(owner, type):
        raise ConfigError.unknown("key", name, known, prefix)


def _replaced(owner: Value, values: Mapping[str, Any], prefix: str) -> Value:
    """Return a dataclass with other values of some fields; the prefix is that of their keys, for messages."""
    return _validated(lambda: replace(owner, **values), values, prefix)  # type: ignore[type-var]


def _validated(create: Callable[[], Value], values: Mapping[str, Any], prefix: str) -> Value:
    """Return what is created; an error of a field names its key, with this prefix, and its value."""
    try:
        return create()
    except ValidationError as error:
        detail = error.errors(include_url=False)[0]
        name = str(detail["loc"][0]) if detail["loc"] else ""
        if name not in values:
            raise ValueError(plain(detail["msg"])) from error
        raise ConfigError.at(f"{prefix}{name}", values[name], plain(detail["msg"])) from error


def plain(message: str) -> str:
    """Return a message of pydantic without its beginning, about a list where it says tuple."""
    return message.replace("a valid tuple", "a list").removeprefix("Value error, ").removeprefix("Input ")


def as_stages(stages: Any) -> Any:
    """Convert the stages of a list, those in the form of YAML included."""
    if isinstance(stages, (str, Mapping)) or not isinstance(stages, Iterable):
        raise ValueError("should be a list of stages, each with what is different from the point")
    return tuple(_as_stage(number, stage) for number, stage in enumerate(stages, 1))


def _as_stage(number: int, stage: Any) -> Any:
    if isinstance(stage, Stage):
        return stage
    if not isinstance(stage, Mapping):
        raise ConfigError.at(
            f"stage {number}", stage, "should map keys to values, as {world.size: 5, task.trials: 20} does"
        )
    try:
        return Stage.of(stage)
    except ValueError as error:
        raise ValueError(f"stage {number}: {error}") from error


def _as_value(value: Any) -> Any:
    return tuple(map(_as_value, value)) if isinstance(value, list) else value
