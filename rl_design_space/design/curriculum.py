"""Curricula: the lists of stages that periods go through (docs/decisions/0030-stages.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, Field, model_validator
from pydantic.dataclasses import dataclass
from typing_extensions import Protocol, runtime_checkable

from rl_design_space._strict import STRICT
from rl_design_space.design.aggregated import Aggregated
from rl_design_space.design.exploration import Constant
from rl_design_space.design.identity import absent_as, full_name
from rl_design_space.design.learned_in_lanes import learned_in_lanes
from rl_design_space.design.stage import Carry, Layout, Refinement, Stage, Value, as_stages
from rl_design_space.design.world import GridSize, World

#: Why values are not carried by observation where blocks are split.
_NEW_PARTS = "the parts of a block are new observations; use same_place, none or a function"

_Trials = Annotated[int, Field(ge=1)]
_ZeroShotTrials = Annotated[int, Field(ge=0)]
_Sizes = Annotated[list[GridSize], Field(min_length=1)]
_Epsilon = Annotated[float, Field(ge=0, le=1)] | None
#: What a stage differs in where the Q-matrix is used as it is.
_AS_IT_IS = {"learner.alpha": 0.0, "exploration": Constant(epsilon=0.0)}


@runtime_checkable
class Curriculum(Protocol):
    """The stages of a period, which share one Q-matrix."""

    def stage_list(self) -> tuple[Stage, ...]:
        """Return the stages in their order; none if a period has one stage, the point itself."""
        ...


def _sizes(sizes: Any) -> Any:
    if sizes in ([], ()):
        raise ValueError("should list the size of a grid, as in [5]; without smaller grids, use curriculum=none")
    return tuple(sizes) if isinstance(sizes, list) else sizes


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Stages:
    """Stages one by one, each with what is different from the point.

    Attributes:
        stages: the stages; with none, a period is learned as the point says.
    """

    stages: Annotated[
        tuple[Stage, ...], BeforeValidator(as_stages, json_schema_input_type=tuple[dict[str, Any], ...])
    ] = ()

    def stage_list(self) -> tuple[Stage, ...]:
        return self.stages


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CoarseToFine:
    """Smaller grids first, with the same places, and then the grid of the point.

    Attributes:
        sizes: size of each grid before that of the point: d, or [dx, dy].
        trials: trials on each of them.
        carry: how a grid takes values over from the one before it.
        zero_shot: trials in which each grid but the first uses the Q-matrix as it is, before learning goes on there.
        epsilon: constant exploration on each grid but the first; as the point explores if None.
    """

    sizes: Annotated[tuple[GridSize, ...], BeforeValidator(_sizes, json_schema_input_type=_Sizes)] = (5,)
    trials: _Trials = 50
    carry: Carry = "same_place"
    zero_shot: _ZeroShotTrials = field(default=0, metadata=absent_as(0, listed=False))
    epsilon: _Epsilon = field(default=None, metadata=absent_as(None, listed=False))

    def stage_list(self) -> tuple[Stage, ...]:
        coarse: list[dict[str, Any]] = [{"world.size": size, "task.trials": self.trials} for size in self.sizes]
        grids = [*coarse, {}]
        following = (_used_and_learned(grid, "scaled", self) for grid in grids[1:])
        return (_staged(grids[0], "scaled", self.carry), *(stage for stages in following for stage in stages))


@dataclass(frozen=True, kw_only=True, config=STRICT)
class NewGoals:
    """The same point on one layout after the other, with one Q-matrix.

    Attributes:
        layouts: number of layouts, that of the point included.
        layout: how the next layout differs: `new`, or all places `shifted`.
        carry: how a layout takes values over from those before it.
        zero_shot: trials in which each layout but the first uses the Q-matrix as it is, before it is learned.
        epsilon: constant exploration on each layout but the first; as the point explores if None.
    """

    layouts: Annotated[int, Field(ge=1)] = 5
    layout: Layout = "new"
    carry: Carry = "same_observation"
    zero_shot: _ZeroShotTrials = field(default=0, metadata=absent_as(0, listed=False))
    epsilon: _Epsilon = field(default=None, metadata=absent_as(None, listed=False))

    def stage_list(self) -> tuple[Stage, ...]:
        following = tuple(_used_and_learned({}, self.layout, self))
        return (Stage(carry=self.carry), *following * (self.layouts - 1))


def _staged(changes: Mapping[str, Any], layout: Layout, carry: Carry) -> Stage:
    return Stage.of({**changes, "layout": layout, "carry": carry})


def _used_and_learned(changes: Mapping[str, Any], layout: Layout, how: CoarseToFine | NewGoals) -> Iterator[Stage]:
    """Yield the stages of a grid or layout that others precede: its zero-shot use, if any, and learning.

    Args:
        changes: what is different from the point.
        layout: how its start and goals follow from those before.
        how: the curriculum.
    """
    if how.zero_shot:
        yield _staged({**changes, **_AS_IT_IS, "task.trials": how.zero_shot}, layout, how.carry)
        # Places that are drawn are drawn once; scaled ones are the same again.
        layout = layout if layout == "scaled" else "same"
    explored = {} if how.epsilon is None else {"exploration": Constant(epsilon=how.epsilon)}
    yield _staged({**changes, **explored}, layout, how.carry)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class ZeroShot:
    """Learning, perhaps on a grid of another size, and then using the Q-matrix as it is: α = 0 and ε = 0.

    Attributes:
        size: size of the grid where the Q-matrix is learned; `same` as that of the point.
        trials: trials in which it is used.
        layout: where start and goals lie then: those of the point (`same`), which have been learned `scaled` to the
            other size; or `new` or `shifted` ones.
        carry: how the Q-matrix is taken over.
    """

    size: GridSize | Literal["same"] = "same"
    trials: _Trials = 20
    layout: Layout = "new"
    carry: Carry = "same_observation"

    def stage_list(self) -> tuple[Stage, ...]:
        learned = Stage() if self.size == "same" else Stage.of({"world.size": self.size, "layout": "scaled"})
        used = Stage.of({**_AS_IT_IS, "task.trials": self.trials, "layout": self.layout, "carry": self.carry})
        return learned, used


@dataclass(frozen=True, kw_only=True, config=STRICT)
class Refine:
    """Large blocks first, which are split as learning goes on; the point has the representation `Aggregated`.

    Attributes:
        split: which blocks are split: those whose cells are `disagreeing`, or `all`, see `Refinement`.
        rows: most rows of a Q-matrix, a whole number; None for any number.
        times: how often blocks are split.
        trials: trials before each time.
        carry: how the parts of a block take values over.
    """

    split: Literal["disagreeing", "all"] = "disagreeing"
    rows: Annotated[int, Field(ge=1)] | None = None
    times: Annotated[int, Field(ge=1)] = 2
    trials: _Trials = 30
    carry: Carry = "same_place"

    @model_validator(mode="after")
    def _parts_are_new_observations(self) -> Refine:
        if self.carry == "same_observation":
            raise ValueError(f"carry=same_observation: {_NEW_PARTS}")
        return self

    def stage_list(self) -> tuple[Stage, ...]:
        short = {"task.trials": self.trials}
        refine = Refinement(split=self.split, rows=self.rows)
        refined = [Stage(changes=short, carry=self.carry, refine=refine)] * (self.times - 1)  # type: ignore[arg-type]
        return (Stage.of(short), *refined, Stage(carry=self.carry, refine=refine))


class StagePoint(NamedTuple):
    """A stage of a point.

    Attributes:
        point: the point as it is in this stage, without stages of its own.
        layout: where start and goals lie, see `Stage`.
        carry: what the Q-matrix begins with, see `Stage`; none in the first stage.
        refine: how the blocks of the stage before are split, see `Stage`.
    """

    point: Any
    layout: Layout
    carry: Carry
    refine: Refinement | None = None


def stages_of(point: Any) -> tuple[StagePoint, ...]:
    """Return the stages of a design point; none if it has one that is the point itself.

    Raises:
        ValueError: a stage contradicts the point or the stage before it.
    """
    listed = point.curriculum.stage_list()
    if not listed:
        return ()
    alone, found = replace(point, curriculum=Stages()), list[StagePoint]()
    places = alone.world
    for number, stage in enumerate(listed, 1):
        try:
            here = StagePoint(stage.applied(alone), stage.layout, stage.carry if found else "none", stage.refine)
            if stage.layout in ("same", "shifted") and here.point.world.shape != places.shape:
                raise ValueError(
                    f"layout={stage.layout}: places on {_shown(places)} are not places on {_shown(here.point.world)}; "
                    "use scaled or new"
                )
            if here.refine:
                _check_refinement(found[-1].point if found else None, here)
            if found:
                _check_carry(found[-1], here)
        except ValueError as error:
            raise ValueError(f"curriculum: stage {number}: {error}") from error
        places = here.point.world if stage.layout == "new" else places
        found.append(here)
    is_alone = len(found) == 1 and found[0].point == alone and found[0].layout in ("same", "scaled")
    return () if is_alone else tuple(found)


def from_scratch(point: Value) -> Value:
    """Return a point with the same stages, each of which begins with nothing: learning with the same budget.

    Raises:
        ValueError: a stage contradicts the point or the stage before it.
    """
    stages = point.curriculum.stage_list()  # type: ignore[attr-defined]
    alone = Stages(stages=tuple(replace(stage, carry="none") for stage in stages))
    return replace(point, curriculum=alone)  # type: ignore[type-var]


def _check_refinement(before: Any, here: StagePoint) -> None:
    """Refuse a stage that cannot refine the blocks of the one before.

    Raises:
        ValueError: there is none, it has no blocks or others, or its errors cannot be known.
    """
    point, refine = here.point, f"refine={here.refine.split if here.refine else None}"
    if before is None:
        raise ValueError(f"{refine}: there is no stage before the first one whose blocks could be split")
    if not isinstance(point.representation, Aggregated):
        name = full_name(type(point.representation))
        raise ValueError(f"{refine}: splits blocks, and {name} has none; use representation=aggregated")
    if before.representation != point.representation or before.world.shape != point.world.shape:
        raise ValueError(
            f"{refine}: splits the blocks of the stage before, so representation and size should be those of that stage"
        )
    if here.carry == "same_observation":
        raise ValueError(f"carry=same_observation, {refine}: {_NEW_PARTS}")
    if not point.msa.repeats:
        raise ValueError(f"{refine}: actions that depend on observations do not know the parts of blocks; use others")
    if here.refine and here.refine.split == "disagreeing" and before.learner.alpha == 0:
        raise ValueError(f"{refine}: the stage before learns nothing (learner.alpha=0), so it has no TD errors")
    if here.refine and here.refine.split == "disagreeing" and not learned_in_lanes(before):
        raise ValueError(
            f"{refine}: TD errors are those of Q-learning with constant α and a schedule of ε in the stage before; "
            "use refine=all, or that learner there"
        )


def _check_carry(stage_before: StagePoint, here: StagePoint) -> None:
    """Refuse a stage to which the Q-matrix of the one before cannot be carried.

    Raises:
        ValueError: the actions, or the meanings of codes, are others.
    """
    before = stage_before.point
    if here.carry == "same_observation" and stage_before.refine:
        raise ValueError(
            "carry=same_observation: the stage before observes other blocks; use same_place, none or a function"
        )
    if here.carry == "same_observation" and before.representation != here.point.representation:
        raise ValueError(
            "carry=same_observation: observations of another representation have another meaning; use same_place, none "
            "or a function"
        )
    if here.carry != "none" and before.msa.limits().tolist() != here.point.msa.limits().tolist():
        raise ValueError(
            f"msa={type(here.point.msa).__name__}: the Q-matrix is that of other actions; use carry: none, or the same "
            "actions in both stages"
        )


def _shown(world: World) -> str:
    return "×".join(map(str, world.shape))
