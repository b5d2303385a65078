"""Outcomes of claims in a multiverse: one row for each specification, and arrays over all of them."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.bounds import Bounds
from rl_design_space.analysis.multiverse.effects import Effect, all_of, effect, with_limits
from rl_design_space.analysis.multiverse.joint import Booleans, Outcomes, Slot
from rl_design_space.analysis.multiverse.margins import Margin, interval
from rl_design_space.report.multiverse_claims import Judgement, Wording
from rl_design_space.report.multiverse_numbers import Asked, Numbers, UnderReadings
from rl_design_space.report.multiverse_points import Base, ReadPoints, Space
from rl_design_space.report.points import Point


@dataclass(frozen=True)
class Row:
    """A specification of a claim and its outcome.

    Attributes:
        reading, measure, statistic, threshold: indices of the choices.
        holds: whether the claim holds; None if that cannot be told.
        value, low, high: of the part that decides, with its 95 % interval.
        what: description of this part.
        margin: see `Margin.value`.
        certainty: see `Margin.certainty`.
    """

    reading: int
    measure: int
    statistic: int
    threshold: int
    holds: bool | None
    value: float = math.nan
    low: float = math.nan
    high: float = math.nan
    what: str = ""
    margin: float = math.nan
    certainty: float = math.nan


@dataclass
class ClaimOutcomes:
    """A claim under every specification.

    Attributes:
        wording: the claim.
        standing: for each reading the one that stands for it: itself, or an earlier one with the same points; -1 if the
            claim does not have its points.
        rows: the distinct specifications.
        verdicts: (readings, measures, statistics, thresholds), 1 where it holds, else 0; of the readings that every
            claim is judged under.
        outcomes: the same for joint specifications.
        missing: message about the first point that is not recorded; empty if there is none.
    """

    wording: Wording
    standing: list[int]
    rows: list[Row]
    verdicts: FloatArray
    outcomes: Outcomes
    missing: str = ""


@dataclass
class _Tally:
    """Where a claim holds, filled in judgement by judgement."""

    rest: Booleans
    slots: dict[Hashable, tuple[Any, dict[Any, Booleans]]] = field(default_factory=dict)

    def note(self, place: tuple[Any, ...], found: Effect) -> None:
        """Note whether everything but the best values holds, and the parts about each best value, for all values."""
        slots = list(found.slots())
        others = [part for part in ((found,) if found.numbers is not None else found.parts) if part not in slots]
        self.rest[place] = np.logical_and.reduce([part.margin.holds for part in others]) if others else True
        for slot in slots:
            assert slot.expected is not None
            expected, held = self.slots.setdefault(slot.expected, (slot.expected[1], {}))
            for value, numbers in ((expected, slot.numbers), *slot.placebos.items()):
                assert numbers is not None
                measured = Bounds(numbers.low[:, :1], numbers.high[:, :1])
                where = held.setdefault(value, np.ones(self.rest.shape, np.bool_))
                where[place] &= Margin.of(measured, slot.low, slot.high).holds


def asked(wording: Wording, points: ReadPoints) -> dict[tuple[Base, str], None]:
    """Return which measures of which points a claim needs, whatever the reading."""
    source = Asked(points)
    for judgement in wording.judgements:
        _ask(judgement, source)
    return source.noted


def _ask(judgement: Judgement, source: Asked) -> None:
    for part in judgement.parts:
        effect(part, source)


def outcomes(wording: Wording, points: ReadPoints, numbers: Numbers, space: Space) -> ClaimOutcomes:
    """Return the outcomes of a claim under every specification.

    Args:
        wording: the claim.
        points: of the study.
        numbers: their measures.
        space: what the specifications are made of.
    """
    standing = _standing(wording, points, space)
    shape = (len(space.readings), len(wording.measures), len(wording.statistics), len(wording.thresholds))
    verdicts, tally = np.zeros(shape), _Tally(np.zeros(shape, np.bool_))
    own = [number for number, stands in enumerate(standing) if stands == number]
    rows: dict[tuple[int, int], Row] = {}
    missing: dict[tuple[int, int], str] = {}
    measured: dict[tuple[int, int], tuple[list[int], list[Effect]]] = {}
    for order, judgement in enumerate(wording.judgements):
        key = judgement.measure, judgement.statistic
        if key not in measured:
            read, why = _read(judgement, points, numbers, {number: space.readings[number] for number in own})
            missing |= {(number, order): text for number, text in why.items()}
            source = UnderReadings(points, numbers, list(read.values()))
            try:
                measured[key] = list(read), [effect(part, source) for part in judgement.parts] if read else []
            except LookupError as error:
                measured[key] = [], []
                missing |= {(number, order): str(error) for number in read}
        there, effects = measured[key]
        rows |= {(number, order): Row(number, *judgement.place, None) for number in own if number not in there}
        if not there:
            continue
        found = all_of([with_limits(*each) for each in zip(effects, judgement.parts, strict=True)])
        rows |= {(row.reading, order): row for row in _rows(there, judgement.place, found)}
        place = (np.array(there), *judgement.place)
        verdicts[place] = found.margin.holds
        tally.note(place, found)
    whole = np.ix_(standing[: space.every], range(shape[1]), range(shape[2]), wording.thresholds)
    slots = [
        Slot(expected, {value: held[whole] for value, held in values.items()})
        for expected, values in tally.slots.values()
    ]
    joint = Outcomes(wording.name, wording.role, tally.rest[whole], slots)
    first = missing[min(missing)] if missing else ""
    return ClaimOutcomes(wording, standing, [rows[key] for key in sorted(rows)], verdicts[whole], joint, first)


def _read(
    judgement: Judgement, points: ReadPoints, numbers: Numbers, readings: Mapping[int, frozenset[int]]
) -> tuple[dict[int, dict[Base, Point]], dict[int, str]]:
    """Return the points of a judgement under each reading, and what is missing under the others.

    Args:
        judgement: of a claim.
        points: of the study.
        numbers: their measures.
        readings: by their numbers.
    """
    source = Asked(points)
    read: dict[int, dict[Base, Point]] = {}
    try:
        _ask(judgement, source)
    except LookupError as error:
        return read, dict.fromkeys(readings, str(error))
    missing: dict[int, str] = {}
    for number, reading in readings.items():
        try:
            there = {base: points.read(base, reading) for base in dict.fromkeys(base for base, _ in source.noted)}
            for base, measure in source.noted:
                numbers.of(there[base], measure)
        except LookupError as error:
            missing[number] = str(error)
        else:
            read[number] = there
    return read, missing


def _rows(readings: Sequence[int], place: tuple[int, int, int], found: Effect) -> Iterator[Row]:
    """Yield the rows of an effect under several readings."""
    margin, leaves, decisive = found.margin, found.leaves, found.decisive
    intervals = [interval(_numbers(leaf)) for leaf in leaves]
    told = zip(
        readings, margin.holds.tolist(), margin.fails.tolist(), margin.value.tolist(), margin.certainty.tolist(),
        decisive.tolist(), strict=True,
    )  # fmt: skip
    for row, (reading, holds, fails, value, certainty, leaf) in enumerate(told):
        low, high = (float(end[row]) for end in intervals[leaf])
        outcome = True if holds else False if fails else None
        number = float(_numbers(leaves[leaf]).low[row, 0])
        yield Row(reading, *place, outcome, number, low, high, leaves[leaf].what, value, certainty)


def _numbers(leaf: Effect) -> Bounds:
    assert leaf.numbers is not None
    return leaf.numbers


def _standing(wording: Wording, points: ReadPoints, space: Space) -> list[int]:
    """Return for each reading the first one under which the claim has the same points; -1 if it has no such points."""
    bases = list(dict.fromkeys(base for base, _ in asked(wording, points)))
    first: dict[Hashable, int] = {}
    standing = []
    for number, reading in enumerate(space.readings):
        if number >= space.every and not points.has(bases, reading):
            standing.append(-1)
            continue
        departures = tuple(points.departure(base, reading) for base in bases)
        standing.append(first.setdefault(departures, number))
    return standing


def choices(wording: Wording, rows: Sequence[Row], space: Space) -> Mapping[str, NDArray[np.bool_]]:
    """Return which specifications of a claim make which choice: (rows,) by name.

    Args:
        wording: the claim.
        rows: its specifications.
        space: what they are made of.
    """
    readings = space.readings
    made = {"the decided reading": np.array([not readings[row.reading] for row in rows])}
    for number, (alternative, decided) in enumerate(space.says):
        has = np.array([number in readings[row.reading] for row in rows])
        if has.any():
            made[alternative], made[decided] = has, ~has & made.get(decided, True)
    for names, of in (
        (wording.measures, [row.measure for row in rows]),
        (wording.statistics, [row.statistic for row in rows]),
        ([f"limits {name}" for name in space.thresholds], [row.threshold for row in rows]),
    ):
        if len(set(of)) > 1:
            made |= {name: np.array(of) == number for number, name in enumerate(names) if number in of}
    return made
