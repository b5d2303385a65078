"""The plain learner of `reference`, for periods of several stages.

A Q-matrix is a dictionary here, too: from what is observed, in words that mean the same in every world, to values. It
holds everything that a period has met since values were last carried in another way than by observation.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rl_design_space.design import AdHoc, DesignPoint, Distance, StagePoint, stages_of
from tests import reference
from tests.reference_streams import WORD, generator_of, layout_of, layout_word


@dataclass
class Staged:
    """What one stage of a period yields, beside what a period does; `carried` counts observations with an ancestor."""

    played: reference.Period
    layout: list[int]
    carried: int
    changed: int


@dataclass
class _Carried:
    """What goes on from stage to stage."""

    point: DesignPoint
    codes: list[list]
    memory: dict = field(default_factory=dict)
    errors: dict = field(default_factory=dict)


def learn_period(point: DesignPoint, period: int) -> list[Staged]:
    """Return all stages of a period."""
    generator = generator_of(point, period)
    found, before = [], None
    for stage, layout in zip(stages_of(point), layouts_of(point, period), strict=True):
        codes = _split(stage, before) if stage.refine else meanings(stage.point, layout[1:])
        actions = _actions(stage.point, layout[1:], codes)
        fresh = [stage.point.learner.initial_q] * len(actions)
        begun = _begun(stage, codes, before)
        q = {code: list(begun.get(code, fresh)) for of_counter in codes for code in of_counter}
        first = {code: list(values) for code, values in q.items()}
        errors: dict = {}
        played = reference.play_trials(stage.point, layout, generator, codes, actions, q, errors)
        changed = sum(q[code] != first[code] for code in q)
        found.append(Staged(played, layout, len(begun.keys() & q.keys()), changed))
        memory = before.memory if before and stage.carry == "same_observation" else {}
        before = _Carried(stage.point, codes, {**memory, **q}, errors)
    return found


def _split(stage: StagePoint, before: _Carried) -> list[list]:
    """Return what a stage with refined blocks observes: the counter and the block, as the places of its cells."""
    width, cells = stage.point.world.shape[0], len(before.codes[0])
    blocks: dict = {}
    for counter, of_counter in enumerate(before.codes):
        for cell, code in enumerate(of_counter):
            blocks.setdefault(code, (counter, []))[1].append((cell % width, cell // width))
    order = list(blocks)
    if stage.refine.split == "disagreeing":
        far = {code: _disagreement(*block, width, before.errors) for code, block in blocks.items()}
        order = sorted((code for code in blocks if far[code] > 0), key=lambda code: -far[code])
    total, parts = len(blocks), dict[object, list]()
    for code in order if stage.refine.split != "none" else ():
        xs, ys = (sorted({place[axis] for place in blocks[code][1]}) for axis in (0, 1))
        halves = [[each[: (len(each) + 1) // 2], each[(len(each) + 1) // 2 :]] for each in (xs, ys)]
        found = [[(x, y) for y in some_y for x in some_x] for some_y in halves[1] for some_x in halves[0]]
        found = [part for part in found if part]
        if total + len(found) - 1 <= (stage.refine.rows or cells * len(before.codes)):
            parts[code] = found
            total += len(found) - 1
    observed = [[None] * cells for _ in before.codes]
    for code, (counter, places) in blocks.items():
        for part in parts.get(code, [places]):
            for x, y in part:
                observed[counter][y * width + x] = (counter, tuple(part))
    return observed


def _disagreement(counter: int, places: list, width: int, errors: dict) -> float:
    """Return the sum of squares between the cells of a block, of the errors of each action."""
    seen = [
        (action, errors[counter, y * width + x, action])
        for x, y in places
        for action in range(1 + max(action for *_, action in errors))
        if (counter, y * width + x, action) in errors
    ]
    sums: dict = {}
    counts: dict = {}
    for action, of_cell in seen:
        sums[action] = sums.get(action, 0.0) + _sum(of_cell)
        counts[action] = counts.get(action, 0) + len(of_cell)
    found = 0.0
    for action, of_cell in seen:
        apart = _sum(of_cell) / len(of_cell) - sums[action] / counts[action]
        found += len(of_cell) * (apart * apart)
    return found


def _sum(values: list[float]) -> float:
    total = 0.0
    for value in values:
        total += value
    return total


def _actions(point: DesignPoint, goals: list[int], codes: list[list]) -> list[reference.Action]:
    """Return the actions, by what is observed instead of by its code."""
    numbered = point.representation.observation(point.world, np.array(goals)).tolist()
    told = [(code, number) for pair in zip(codes, numbered, strict=True) for code, number in zip(*pair, strict=True)]
    actions = reference.actions_of(point, goals)
    return [
        reference.Action(each.limit, {code: each.at[number] for code, number in told if number in each.at})
        for each in actions
    ]


def _begun(stage: StagePoint, codes: list[list], before: _Carried | None) -> dict:
    """Return the values that a Q-matrix begins with."""
    if before is None or stage.carry == "none":
        return {}
    if stage.carry == "same_observation":
        return before.memory
    (width, height), (old_width, old_height) = stage.point.world.shape, before.point.world.shape
    begun, counts = {}, {}
    for counter, of_counter in enumerate(codes):
        for cell, code in enumerate(of_counter):
            x, y = cell % width, cell // width
            # The old cell with the centre of this one, in units of half a cell of this world.
            old_x, old_y = int((x + 0.5) * old_width / width), int((y + 0.5) * old_height / height)
            values = before.memory[before.codes[counter][old_y * old_width + old_x]]
            counts[code] = counts.get(code, 0) + 1
            mean = begun.get(code, values)
            begun[code] = [old + (new - old) / counts[code] for old, new in zip(mean, values, strict=True)]
    return begun


def meanings(point: DesignPoint, goals: list[int]) -> list[list]:
    """Return what the agent observes by success counter and cell; codes where they mean the same in every world."""
    world, representation = point.world, point.representation
    width, height = world.shape
    if isinstance(representation, AdHoc):
        return [[(s, c % width, c // width) for c in range(width * height)] for s in range(len(goals))]
    if isinstance(representation, Distance):
        x, y = (part.tolist() for part in world.offset(np.array(goals)))
        far = [[abs(a) + abs(b) for a, b in zip(*pair, strict=True)] for pair in zip(x, y, strict=True)]
        is_seen = {"all": lambda s, g: True, "remaining": lambda s, g: g >= s, "due": lambda s, g: g == s}
        seen = lambda s, g: far[g] if is_seen[representation.goals](s, g) else None  # noqa: E731
        return [
            [(s, *(seen(s, g) and seen(s, g)[c] for g in range(len(goals)))) for c in range(width * height)]
            for s in range(len(goals))
        ]
    return representation.observation(world, np.array(goals)).tolist()


def layouts_of(point: DesignPoint, period: int) -> list[list[int]]:
    """Return start and goals of each stage."""
    places, world, number = layout_of(point, period), point.world, 0
    found = []
    for stage in stages_of(point):
        (width, height), here = world.shape, stage.point.world
        if stage.layout == "new":
            number += 1
            places, world = layout_of(stage.point, period, number), here
        elif stage.layout == "shifted":
            number += 1
            word = layout_word(point, period, number)
            offset = 1 + word * (width * height - 1) // WORD
            right, down = offset % width, offset // width
            places = [(c // width + down) % height * width + (c % width + right) % width for c in places]
        found.append(_scaled(places, world, here) if stage.layout == "scaled" else places)
    return found


def _scaled(places: list[int], world, here) -> list[int]:
    (width, height), (new_width, new_height) = world.shape, here.shape
    settled: list[int] = []
    for cell in places:
        x, y = int((cell % width + 0.5) * new_width / width), int((cell // width + 0.5) * new_height / height)
        wanted = y * new_width + x
        from_x, from_y = (part[0].tolist() for part in here.offset(np.array([wanted])))
        free = [c for c in range(new_width * new_height) if c not in settled]
        settled.append(min(free, key=lambda c: (abs(from_x[c]) + abs(from_y[c]), c)))
    return settled
