"""The answers of `rl-design-space show`, for the terminal and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from rl_design_space.catalogue.choices import choice
from rl_design_space.catalogue.options import Option, Options
from rl_design_space.catalogue.records import choice_record, parameter_records, study_record, whole_option_record
from rl_design_space.catalogue.schemas import schema_files
from rl_design_space.catalogue.search import Search
from rl_design_space.catalogue.studies import study
from rl_design_space.catalogue.subjects import parameters, subject
from rl_design_space.commands.catalogue_tables import choice_table, parameter_table, study_parts
from rl_design_space.errors import ConfigError

_SCHEMAS = "schemas"


class Answer(NamedTuple):
    """The description of a subject.

    Attributes:
        parts: for the terminal, from top to bottom.
        record: the same content for JSON.
    """

    parts: Sequence[RenderableType]
    record: Mapping[str, Any]


def answer(search: Search, text: str, overrides: Sequence[str]) -> Answer:
    """Return the description of a subject.

    Args:
        search: where to find the config files.
        text: the subject, see `subjects.subject`, or `schemas`.
        overrides: overrides of a study.

    Raises:
        ConfigError: the subject does not exist, or accepts no overrides.
    """
    if text == _SCHEMAS and not overrides:
        return _of_schemas()
    about = subject(search, text)
    if overrides and about.choice != "study":
        raise ConfigError(
            f"{overrides[0]}: only studies accept overrides, as in `rl-design-space show study=NAME {overrides[0]}`"
        )
    if about.key:
        found = parameters(search, about.key)
        first = "option" if about.key.partition(".")[0] in search.groups else "parameter"
        return Answer([parameter_table(found, first)], parameter_records(found))
    options = Options(search)
    if not about.option:
        whole = choice(search, options, about.choice, counted=True)
        return Answer([choice_table([whole])], choice_record(whole))
    if about.choice == "study":
        entry = study(search, options.planner, about.option, overrides)
        return Answer(list(study_parts(entry)), study_record(entry))
    option = options.option(about.choice, about.option)
    return Answer(list(_option_parts(option)), whole_option_record(option))


def _option_parts(option: Option) -> Iterable[RenderableType]:
    yield Text(option.description)
    if option.error:
        yield Text(f"cannot be used: {option.error}", style="red")
    yield parameter_table(option.parameters) if option.parameters else "no parameters"
    if option.target:
        yield f"class: {option.target}"
    yield f"file: {option.place}"


def _of_schemas() -> Answer:
    """Return the paths of the JSON Schemas and the patterns of the files that they describe, for editors."""
    table = Table.grid(padding=(0, 2))
    for pattern, path in (files := schema_files()).items():
        table.add_row(pattern, str(path))
    return Answer([table], {str(path): [pattern] for pattern, path in files.items()})
