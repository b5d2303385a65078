"""A parser of arguments that refuses a flag of one value if it is given twice; argparse would take the last one."""

from __future__ import annotations

import argparse
from typing import Any

from rl_design_space.errors import ConfigError

#: Metavar of flags whose one value may be several parameters with commas between.
SEVERAL = "PARAMS"


class Parser(argparse.ArgumentParser):
    """A parser whose flags of one value may be given once."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.register("action", None, _Once)


class _Once(argparse.Action):
    """Store a value; refuse a second one of the same flag."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        seen = f"{self.dest} was typed"  # no name of a flag has spaces
        if option_string and hasattr(namespace, seen):
            first = getattr(namespace, self.dest)
            expected = f"should be one, such as {option_string} {first},{values}" if self.metavar == SEVERAL else ""
            raise ConfigError(
                f"{option_string} {first}, {option_string} {values}: {expected or 'should be given once'}"
            )
        setattr(namespace, self.dest, values)
        if option_string:
            setattr(namespace, seen, True)
