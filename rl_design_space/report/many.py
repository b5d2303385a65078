"""Many lines or rows in one picture: the few that have a name, and what the others have in common."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated

from pydantic import BeforeValidator, Field

from rl_design_space.errors import ConfigError

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
