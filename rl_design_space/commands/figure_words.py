"""The commands `rl-design-report heatmap`, `importance` and others: figures of any recorded runs."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rl_design_space._paths import leads_out
from rl_design_space.commands.figure_arguments import BY_WORD, NAMED, WORDS, parsed, where_of
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

__all__ = ["WORDS", "main"]

if TYPE_CHECKING:
    from rl_design_space.report.base import Report

#: How to include runs of earlier code.
_INCLUDING = {"heatmap": "--rows representation.source", "curves": "--by representation.source"}
_INCLUDING_ELSEWHERE = "--where representation.source=…"


def main(word: str, arguments: Sequence[str]) -> list[Path]:
    """Draw the figure of a word.

    Args:
        word: one of `WORDS`.
        arguments: of the command line, after the word.

    Returns:
        The files written.

    Raises:
        ConfigError: there are no such runs, or they have no such parameter or value.
    """
    chosen = parsed(word, arguments)
    if unknown := [word_ for word_ in chosen.overrides if "=" not in word_]:
        raise ConfigError(f"{unknown[0]}: not an override; should be KEY=VALUE, such as outputs=elsewhere")
    if leads_out(chosen.name or ""):
        raise ConfigError.at("--name", chosen.name, "should be a name without ..; outputs=DIR writes elsewhere")

    from rl_design_space.commands.folders import report_folder
    from rl_design_space.commands.messages import tell
    from rl_design_space.commands.unused_variables import tell_of_unused_variables
    from rl_design_space.commands.watching import tell_all, tell_numbers, watched
    from rl_design_space.report.parameters import PERIODS
    from rl_design_space.report.runs import Runs
    from rl_design_space.run.settings import settings_of
    from rl_design_space.tracking.selection import SOURCE

    where, also_typed = where_of(chosen.where)
    if word in BY_WORD:
        chosen.given, more_typed = where_of(chosen.given, "--given")
        also_typed = [*also_typed, *more_typed]
    settings = settings_of([*also_typed, *chosen.overrides])
    folder = report_folder(settings)
    tell_of_unused_variables(settings.tracking)
    reader = settings.tracking.reader()
    figure = _figure(word, chosen)
    command = shlex.join(["rl-design-report", *user_config.flags(), word, *arguments])
    of_any_code = any(SOURCE in argument for argument in arguments)
    frame, left_out = reader.select(chosen.study, chosen.filter, where, outdated=of_any_code)
    remarks = []
    if left_out:
        including = _INCLUDING.get(word, _INCLUDING_ELSEWHERE)
        tell(f"{left_out}; to include them, name their code, as in {including}")
        remarks = [f"{left_out.capitalize()}."]
    every = any(PERIODS in argument for argument in arguments)
    runs = Runs.of_frame(frame, reader, command, remarks, every=every)
    runs.watch, runs.tell = watched, tell_all
    name = chosen.name or (word if word in NAMED else _name(word, figure.heading))
    paths = figure.write_runs(runs, folder / name)
    if word not in BY_WORD:  # the others print lines of their own
        tell_numbers(paths)
    return paths


def _figure(word: str, chosen: argparse.Namespace) -> Report:
    from rl_design_space import report
    from rl_design_space.config.build import construct

    kind: Any = getattr(report, word.capitalize())
    names = {field.name for field in fields(kind)}
    figure: Report = construct(kind, {name: value for name, value in vars(chosen).items() if name in names})
    return figure


def _name(word: str, heading: str) -> str:
    """Return the name of the files of a heading."""
    return f"{word}-{re.sub(r'[^A-Za-z0-9.]+', '-', heading).strip('-')}"
