"""Choices, parameters and studies as tables for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from rl_design_space._yaml import as_yaml
from rl_design_space.catalogue.options import NOT_GIVEN, Choice, Option, Parameter
from rl_design_space.catalogue.studies import StudyEntry
from rl_design_space.catalogue.wording import kind_in_words, range_in_words
from rl_design_space.commands.terminal import plan_lines, plan_table
from rl_design_space.plan.variations import Variations

#: Characters of a default that a table shows, and what stands for the rest.
_LONGEST, _CUT = 200, " …"


def choice_table(choices: Sequence[Choice]) -> Table:
    """Return a table of choices with their options; of studies with their points if these were counted."""
    table = _table("choice")
    table.add_column("option", no_wrap=True)
    if counted := any(choice.points is not None for choice in choices):
        table.add_column("points", justify="right")
    table.add_column("description", overflow="fold")
    between = [""] if counted else []
    for choice in choices:
        table.add_row(Text(choice.name), "", *between, Text(choice.description, style="italic"))
        for option in choice.options:
            last = option is choice.options[-1]
            table.add_row("", *_option_row(choice, option), end_section=last)
    return table


def parameter_table(parameters: Iterable[Parameter], first: str = "parameter") -> Table:
    """Return a table of parameters with their types, ranges and defaults."""
    table = _table(first)
    table.add_column("type")
    table.add_column("range", overflow="fold")
    table.add_column("default", overflow="fold")
    table.add_column("description", overflow="fold", ratio=1)
    for each in parameters:
        default = "" if each.default is NOT_GIVEN else _shortened(each.default)
        if default.endswith(_CUT):
            table.caption = f"{_CUT.strip()}: shortened; --json shows the whole value"
        row = (each.name, kind_in_words(each.schema), range_in_words(each.schema), default, each.description)
        table.add_row(*map(Text, row))
    return table


def block_table(study: StudyEntry) -> Table:
    """Return a table of the blocks of a study with their sweeps."""
    table = _table("block")
    table.add_column("all combinations of", overflow="fold")
    for block, sweeps in study.blocks.items():
        table.add_row(Text(block), Text("  ".join(f"{key}={as_yaml(value)}" for key, value in sweeps.items())))
    return table


def constraint_table(study: StudyEntry) -> Table:
    """Return a table of the constraints of a study: what each excludes, and why."""
    table = _table("constraint")
    table.add_column("excludes", overflow="fold")
    table.add_column("reason", overflow="fold")
    for name, constraint in study.constraints.items():
        table.add_row(*map(Text, (name, constraint.drop, constraint.why)))
    return table


def variation_table(variations: Variations) -> Table:
    """Return a table of the readings that change the points of a study."""
    table = _table("reading")
    table.add_column("changes", overflow="fold")
    for reading, values in variations.readings.items():
        table.add_row(Text(reading), Text("  ".join(f"{key}={as_yaml(value)}" for key, value in values.items())))
    return table


def study_parts(study: StudyEntry) -> Iterable[Table | Text | str]:
    """Yield the description of a study, from top to bottom."""
    yield Text(study.description)
    if study.blocks:
        yield block_table(study)
    if study.includes:
        yield f"includes the points of {', '.join(study.includes)}"
    if study.constraints:
        yield constraint_table(study)
    if study.variations:
        yield variation_table(study.variations)
        together = f"alone and up to {study.variations.order} together" if study.variations.order > 1 else "alone"
        also = (" + ".join(names) for names in study.variations.also)
        around = (f"{' + '.join(names)} with each other one" for names in study.variations.around)
        yield f"combined: {'; '.join([together, *also, *around])}"
    if study.plan.axes:
        yield plan_table(study.plan)
    if study.plan:
        yield from plan_lines(study.plan)
    else:
        yield "no points: the report needs none"
    if study.report:
        yield f"report: {study.report}"
    yield f"file: {study.place}"


def _shortened(value: Any) -> str:
    """Return a value as YAML; of a long one, what it begins with."""
    whole = as_yaml(value)
    if len(whole) <= _LONGEST:
        return whole
    if isinstance(value, Mapping):
        keys = ", ".join(str(name) for name in value if name != "_target_")
        return " with ".join(filter(None, (value.get("_target_"), keys))) + _CUT
    return whole[:_LONGEST].rstrip() + _CUT


def _table(first: str) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column(first, style="bold", no_wrap=True)
    return table


def _option_row(choice: Choice, option: Option) -> list[str | Text]:
    name = f"{option.name} (default)" if option.name == choice.default else option.name
    count = (choice.points or {}).get(option.name)
    error = option.error or (count if isinstance(count, str) else "")
    counted = [] if choice.points is None else [f"{count:,}" if isinstance(count, int) else "–"]
    return [Text(name), *counted, _with_error(option.summary, error)]


def _with_error(summary: str, error: str) -> Text:
    lines = [Text(summary), Text(f"cannot be used: {error}" if error else "", style="red")]
    return Text("\n").join(filter(None, lines))
