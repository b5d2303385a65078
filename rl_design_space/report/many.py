"""Many lines or rows in one picture: the few that have a name, and what the others have in common."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from typing import Annotated

from pydantic import BeforeValidator, Field

from rl_design_space.errors import ConfigError
from rl_design_space.report.parameters import text

#: Lines or rows by values of their parameters, as on the command line.
Named = Annotated[
    tuple[str, ...],
    BeforeValidator(
        lambda names: (names,) if isinstance(names, str) else tuple(names), json_schema_input_type=str | list[str]
    ),
]
#: How many rows a table or a picture has at most.
Top = Annotated[int, Field(ge=1)]
#: Quantiles between which most of the others lie, and half of them.
MOST, HALF = (0.1, 0.9), (0.25, 0.75)
#: Letters: of a name that has room in a picture, and of a line of one that has not.
_LONG, _LINE = 60, 90


def apart(names: Sequence[str]) -> tuple[list[str], str]:
    """Return names for a picture, in lines, and what all of them have in common if some are long.

    Parameters that a name has not, `exploration.k=–`, are left out as long as no two names become the same.

    Args:
        names: values of parameters, as on the command line.

    Returns:
        The names without their common parts, and a note that lists these; no note, and all parts, if all are short.
    """
    names = _without_missing(names)
    if max(map(len, names), default=0) <= _LONG:
        return names, ""
    parts = [name.split() for name in names]
    common = [part for part in parts[0] if len(parts) > 1 and all(part in other for other in parts)]
    shorter = [" ".join(part for part in each if part not in common) for each in parts]
    note = f"In common: {' '.join(common)}" if common else ""
    return [textwrap.fill(name, _LINE) for name in shorter], note


def _without_missing(names: Sequence[str]) -> list[str]:
    shorter = [" ".join(part for part in name.split(" ") if not part.endswith(f"={text(None)}")) for name in names]
    return shorter if len(set(shorter)) == len(set(names)) and all(shorter) else list(names)


def named(names: Iterable[str], wanted: Sequence[str]) -> list[str]:
    """Return the names that have all parts of a wanted one: `msa=none` is a part of `msa=none reward=end_reward`.

    Raises:
        ConfigError: no name has them.
    """
    found = []
    for each in wanted:
        having = [name for name in names if set(each.split()) <= set(name.split())]
        if not having:
            raise ConfigError.at("named", each, "nothing that is shown has these values; the CSV file lists what is")
        found += having
    return list(dict.fromkeys(found))


def without_effect(wanted: Sequence[str], number: int, most: int, what: str) -> list[str]:
    """Return a note if names were asked for where all are shown anyway.

    Args:
        wanted: names that were asked for.
        number: of lines or rows.
        most: number of them up to which all are shown.
        what: word for one of them.
    """
    if not wanted or number > most:
        return []
    return [f"named={', '.join(wanted)} changes nothing: all {number} {what}s are shown by name."]
