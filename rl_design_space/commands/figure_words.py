"""The commands `rl-design-report heatmap`, `importance` and others: figures of any recorded runs."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rl_design_space._paths import leads_out
from rl_design_space.commands.figure_arguments import BY_WORD, NAMED, WORDS, look_names, parsed
from rl_design_space.commands.look_arguments import named_by_flags, take_look, unused_labels
from rl_design_space.commands.where import where_of
from rl_design_space.config import user_config
from rl_design_space.config.overrides import is_of_study
from rl_design_space.errors import ConfigError

__all__ = ["WORDS", "main"]

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.report.base import Report
    from rl_design_space.tracking.read import RunReader

#: Flags of words that take several values.
_SEVERAL = {"explore": ("values", "curves"), "sensitivity": ("named",), "compare": ("named",)}
#: Flags that take several names, with commas between them.
_OF_NAMES = ("--rows", "--cols", "--by")
#: The word that writes a page instead of a figure, and the learning curves in it.
EXPLORE, _CURVES = "explore", ("steps/mean", "success_rate")

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
        raise ConfigError(f"{unknown[0]}: {_why_unknown(list(arguments), unknown[0])}")
    if leads_out(chosen.name or ""):
        raise ConfigError.at("--name", chosen.name, "should be a name without ..; outputs=DIR writes elsewhere")

    from rl_design_space.commands.folders import report_folder
    from rl_design_space.commands.left_files import tell_of_left
    from rl_design_space.commands.main_numbers import tell_numbers
    from rl_design_space.commands.messages import tell
    from rl_design_space.commands.unused_variables import tell_of_unused_variables
    from rl_design_space.commands.watching import watched
    from rl_design_space.config.overrides import is_setting
    from rl_design_space.plan.study_values import study_values
    from rl_design_space.report.parameters import PERIODS
    from rl_design_space.report.runs import Runs
    from rl_design_space.run.settings import reading_settings_of
    from rl_design_space.tracking.selection import SOURCE

    where, also_typed = where_of(chosen.where)
    if word in BY_WORD:
        chosen.given, more_typed = where_of(chosen.given, "--given")
        also_typed = [*also_typed, *more_typed]
    look, more_typed = take_look(chosen, look_names(word))
    also_typed += more_typed
    for flag in _SEVERAL.get(word, ()):  # settings may follow these flags, as they may follow --where
        also_typed += filter(is_setting, getattr(chosen, flag))
        setattr(chosen, flag, [each for each in getattr(chosen, flag) if not is_setting(each)])
    settings = reading_settings_of(_without_study([*also_typed, *chosen.overrides]))
    folder = report_folder(settings)
    tell_of_unused_variables(settings.tracking)
    reader = settings.tracking.reader()
    figure = None if word == EXPLORE else _figure(word, chosen, look)
    command = shlex.join(["rl-design-report", *user_config.flags(), word, *arguments])
    of_any_code = any(SOURCE in argument for argument in arguments)
    frame, left_out = reader.select(chosen.study, chosen.filter, where, outdated=of_any_code)
    for note in unused_labels(chosen.labels, frame):
        tell(note)
    remarks = []
    if left_out:
        including = _INCLUDING.get(word, _INCLUDING_ELSEWHERE)
        tell(f"{left_out}; to include them, name their code, as in {including}")
        remarks = [f"{left_out.capitalize()}."]
    if figure is None:
        return _explore(chosen, look, frame, reader, folder, command)
    every = any(PERIODS in argument for argument in arguments)
    listed = study_values(chosen.study) if chosen.study else {}
    runs = Runs.of_frame(frame, reader, command, remarks, every=every, listed=listed, asked=arguments)
    runs.watch = watched
    name = chosen.name or (word if word in NAMED else _name(word, figure.heading))
    with named_by_flags():
        written = figure.write_runs(runs, folder / name)
    tell_numbers(written.numbers)
    tell_of_left(written, written.left)
    return written


def _why_unknown(arguments: list[str], word: str) -> str:
    """Return what is wrong with a word that is no override."""
    place = arguments.index(word)
    flag, first = ["", "", *arguments][place : place + 2]
    if flag in _OF_NAMES:
        return f"not an override; several names after {flag} are one word, as in {flag} {first},{word}"
    return "not an override; should be KEY=VALUE, such as outputs=elsewhere"


def _without_study(settings: list[str]) -> list[str]:
    """Return settings among which no study is named.

    Raises:
        ConfigError: one is, which the flag does.
    """
    for override in filter(is_of_study, settings):
        name = override.partition("=")[2].partition(",")[0]
        raise ConfigError(f"{override}: not a parameter of runs; --study {name or 'NAME'} selects the runs of a study")
    return settings


def _explore(
    chosen: argparse.Namespace,
    look: Mapping[str, Any],
    frame: pd.DataFrame,
    reader: RunReader,
    folder: Path,
    command: str,
) -> list[Path]:
    """Write the page that shows any runs."""
    from rl_design_space.commands.watching import watched
    from rl_design_space.config.build import construct
    from rl_design_space.learning.measures import SCALARS, canonical
    from rl_design_space.plan.study_values import study_values
    from rl_design_space.report.explore import write_explorer
    from rl_design_space.report.look import Look

    names = [canonical(word) for word in chosen.values]
    if new := [name for name in names if name not in frame]:
        frame[new] = reader.measured(frame, new)
    if look.get("scale") not in (None, "linear", "log"):
        raise ConfigError.at("--scale", look["scale"], "should be linear or log")
    return write_explorer(
        frame,
        reader,
        folder / f"{chosen.name or EXPLORE}.html",
        numbers=list(dict.fromkeys([*names, *(name for name in SCALARS if name in frame)])),
        curves=chosen.curves or list(_CURVES),
        ui=chosen.ui,
        title=chosen.title or (f"Runs of {chosen.study}" if chosen.study else "All recorded runs"),
        made_by=command,
        watch=watched,
        look=construct(Look, look),
        listed=study_values(chosen.study) if chosen.study else {},
    )


def _figure(word: str, chosen: argparse.Namespace, look: Mapping[str, Any]) -> Report:
    from rl_design_space import report
    from rl_design_space.config.build import construct

    kind: Any = getattr(report, word.capitalize())
    names = {field.name for field in fields(kind)}
    given = {name: value for name, value in vars(chosen).items() if name in names and name not in look_names(word)}
    with named_by_flags():
        figure: Report = construct(kind, {**given, **look})
    return figure


def _name(word: str, heading: str) -> str:
    """Return the name of the files of a heading."""
    return f"{word}-{re.sub(r'[^A-Za-z0-9.]+', '-', heading).strip('-')}"
