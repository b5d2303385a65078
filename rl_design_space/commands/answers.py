"""What `rl-design-space show` says of its subject, to people and to programs."""

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
    """What is known of a subject.

    Attributes:
        parts: for people, from top to bottom.
        record: the same for programs.
    """

    parts: Sequence[RenderableType]
    record: Mapping[str, Any]


def answer(search: Search, text: str, overrides: Sequence[str]) -> Answer:
    """Look something up.

    Args:
        search: finds the files.
        text: what is asked for, see `subjects.subject`; or `schemas`.
        overrides: of the points of a study.

    Raises:
        ConfigError: there is no such thing, or it takes no overrides.
    """
    if text == _SCHEMAS and not overrides:
        return _of_schemas()
    meant = subject(search, text)
    if overrides and meant.choice != "study":
        raise ConfigError(f"{overrides[0]}: only a study is shown with overrides, as in show study=NAME {overrides[0]}")
    if meant.key:
        found = parameters(search, meant.key)
        first = "option" if meant.key.partition(".")[0] in search.groups else "parameter"
        return Answer([parameter_table(found, first)], parameter_records(found))
    options = Options(search)
    if not meant.option:
        whole = choice(search, options, meant.choice, counted=True)
        return Answer([choice_table([whole])], choice_record(whole))
    if meant.choice == "study":
        entry = study(search, options.planner, meant.option, overrides)
        return Answer(list(study_parts(entry)), study_record(entry))
    option = options.option(meant.choice, meant.option)
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
    """Where the JSON Schemas of config files lie, and which files they are for, as editors want to know it."""
    table = Table.grid(padding=(0, 2))
    for pattern, path in (files := schema_files()).items():
        table.add_row(pattern, str(path))
    return Answer([table], {str(path): [pattern] for pattern, path in files.items()})
