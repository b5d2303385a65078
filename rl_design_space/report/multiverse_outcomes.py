"""Outcomes of claims in a multiverse: one row for each specification, and arrays over all of them."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rl_design_space._arrays import FloatArray
from rl_design_space.analysis.multiverse.effects import Effect, all_of, effect, with_limits
from rl_design_space.analysis.multiverse.joint import Booleans, Outcomes, Slot
from rl_design_space.analysis.multiverse.margins import Margin, interval
from rl_design_space.report.multiverse_claims import Judgement, Wording
from rl_design_space.report.multiverse_numbers import Asked, Numbers, UnderReading
from rl_design_space.report.multiverse_points import ReadPoints


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
        readings: for each reading, the one that stands for it: itself, or an earlier one with the same points.
        rows: the distinct specifications.
        verdicts: (readings, measures, statistics, thresholds), 1 where it holds, else 0.
        outcomes: the same for joint specifications.
        missing: message about the first point that is not recorded; empty if there is none.
    """

    wording: Wording
    readings: Sequence[int]
    rows: list[Row]
    verdicts: FloatArray
    outcomes: Outcomes
    missing: str = ""


@dataclass
class _Tally:
    """Where a claim holds, filled in reading by reading."""

    rest: Booleans
    slots: dict[Hashable, tuple[Any, dict[Any, Booleans]]] = field(default_factory=dict)

    def note(self, place: tuple[int, ...], found: Effect) -> None:
        """Note whether everything but the best values holds, and the parts about each best value, for all values."""
        slots = list(found.slots())
        others = [part for part in ((found,) if found.numbers is not None else found.parts) if part not in slots]
        self.rest[place] = all(part.margin.holds is True for part in others)
        for slot in slots:
            assert slot.expected is not None
            expected, held = self.slots.setdefault(slot.expected, (slot.expected[1], {}))
            for value, numbers in ((expected, slot.numbers), *slot.placebos.items()):
                assert numbers is not None
                holds = Margin.of(numbers.__class__(*(side[:1] for side in numbers)), slot.low, slot.high).holds is True
                where = held.setdefault(value, np.ones(self.rest.shape, np.bool_))
                where[place] &= holds


def asked(wording: Wording, points: ReadPoints) -> dict[tuple[Hashable, str], None]:
    """Return which measures of which points a claim needs, whatever the reading."""
    source = Asked(points)
    for judgement in wording.judgements:
        for part in judgement.parts:
            effect(part, source)
    return source.noted


def outcomes(
    wording: Wording, points: ReadPoints, numbers: Numbers, readings: Sequence[frozenset[int]]
) -> ClaimOutcomes:
    """Return the outcomes of a claim under every specification.

    Args:
        wording: the claim.
        points: of the study.
        numbers: their measures.
        readings: by the numbers of their alternatives.
    """
    standing = _standing(wording, points, readings)
    shape = (len(readings), len(wording.measures), len(wording.statistics), len(wording.thresholds))
    verdicts, tally = np.zeros(shape), _Tally(np.zeros(shape, np.bool_))
    rows: list[Row] = []
    missing = ""
    for number, reading in enumerate(readings):
        if standing[number] != number:
            continue
        source = UnderReading(points, numbers, reading)
        measured: dict[tuple[int, int], list[Effect]] = {}
        for judgement in wording.judgements:
            place = (number, *judgement.place)
            try:
                found = all_of(_effects(judgement, source, measured))
            except LookupError as error:
                missing = missing or str(error)
                rows.append(Row(*place, None))
                continue
            rows.append(_row(place, found))
            verdicts[place] = rows[-1].holds is True
            tally.note(place, found)
    whole = np.ix_(standing, range(shape[1]), range(shape[2]), wording.thresholds)
    slots = [
        Slot(expected, {value: held[whole] for value, held in values.items()})
        for expected, values in tally.slots.values()
    ]
    joint = Outcomes(wording.name, wording.role, tally.rest[whole], slots)
    return ClaimOutcomes(wording, standing, rows, verdicts[whole], joint, missing)


def _effects(judgement: Judgement, source: UnderReading, measured: dict[tuple[int, int], list[Effect]]) -> list[Effect]:
    """Return the effects of the parts; those of the same measure under other limits have the same numbers."""
    key = judgement.measure, judgement.statistic
    if key not in measured:
        measured[key] = [effect(part, source) for part in judgement.parts]
        return measured[key]
    return [with_limits(*each) for each in zip(measured[key], judgement.parts, strict=True)]


def _row(place: tuple[int, int, int, int], found: Effect) -> Row:
    margin, decisive = found.margin, found.decisive
    assert decisive.numbers is not None
    low, high = interval(decisive.numbers)
    value = float(decisive.numbers.low[0])
    return Row(*place, margin.holds, value, low, high, decisive.what, margin.value, margin.certainty)


def _standing(wording: Wording, points: ReadPoints, readings: Sequence[frozenset[int]]) -> list[int]:
    """Return for each reading the first one under which the claim has the same points."""
    bases = list(dict.fromkeys(base for base, _ in asked(wording, points)))
    first: dict[Hashable, int] = {}
    standing = []
    for number, reading in enumerate(readings):
        departures = tuple(points.departure(base, reading) for base in bases)
        standing.append(first.setdefault(departures, number))
    return standing


def choices(
    found: ClaimOutcomes,
    readings: Sequence[frozenset[int]],
    says: Sequence[tuple[str, str]],
    thresholds: Sequence[str],
) -> Mapping[str, NDArray[np.bool_]]:
    """Return which specifications of a claim make which choice: (rows,) by name.

    Args:
        found: the claim.
        readings: by the numbers of their alternatives.
        says: what each alternative says, and what the decided reading says in its place.
        thresholds: names of the sets of limits.
    """
    rows = found.rows
    made = {"the decided reading": np.array([not readings[row.reading] for row in rows])}
    for number, (alternative, decided) in enumerate(says):
        has = np.array([number in readings[row.reading] for row in rows])
        if has.any():
            made[alternative], made[decided] = has, ~has & made.get(decided, True)
    for names, of in (
        (found.wording.measures, [row.measure for row in rows]),
        (found.wording.statistics, [row.statistic for row in rows]),
        ([f"limits {name}" for name in thresholds], [row.threshold for row in rows]),
    ):
        if len(set(of)) > 1:
            made |= {name: np.array(of) == number for number, name in enumerate(names) if number in of}
    return made
