"""The commands `rl-design-report heatmap`, `curves`, `sensitivity` and `compare`: figures of any recorded runs."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rl_design_space._paths import leads_out
from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

if TYPE_CHECKING:
    from rl_design_space.report.base import Report

#: How to include runs of earlier code.
_INCLUDING = {
    "heatmap": "--rows representation.source",
    "curves": "--by representation.source",
    "sensitivity": "--where representation.source=…",
    "compare": "--where representation.source=…",
}
_VALUE = (
    "which scalar or measure: total_steps, steps_after=30, trials_to=1.1,statistic=median, or module and function of "
    "your own (default: %(default)s); docs/reports.md lists them"
)
#: Words of the command, with what they draw.
WORDS = {
    "heatmap": "a number by two parameters, as a table of colours",
    "curves": "learning curves by the values of parameters",
    "sensitivity": "how much a number depends on one parameter",
    "compare": "two choices side by side, everything else equal, paired by period",
}


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
    chosen = _parser(word).parse_intermixed_args(arguments)
    if unknown := [word_ for word_ in chosen.overrides if "=" not in word_]:
        raise ConfigError(f"{unknown[0]}: not an override; should be KEY=VALUE, such as outputs=elsewhere")
    if leads_out(chosen.name or ""):
        raise ConfigError.at("--name", chosen.name, "should be a name without ..; outputs=DIR writes elsewhere")

    from rl_design_space.commands.folders import report_folder
    from rl_design_space.commands.messages import tell
    from rl_design_space.commands.unused_variables import tell_of_unused_variables
    from rl_design_space.report.runs import Runs
    from rl_design_space.run.settings import settings_of
    from rl_design_space.tracking.selection import SOURCE

    where, also_typed = _where(chosen.where)
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
        tell(f"{left_out}; to include them, name their code, as in {_INCLUDING[word]}")
        remarks = [f"{left_out.capitalize()}."]
    runs = Runs.of_frame(frame, reader, command, remarks)
    name = chosen.name or _name(word, figure.heading)
    return figure.write_runs(runs, folder / name)


def flags(word: str) -> list[str]:
    """Return the flags of a word."""
    return [flag for action in _parser(word)._actions for flag in action.option_strings if flag.startswith("--")]


def values() -> list[str]:
    """Return what may follow `--value`: scalars, and measures with their usual parameters."""
    from rl_design_space.learning.measures import ONLY_SCALARS, forms

    return [*forms(), *ONLY_SCALARS]


def _parser(word: str) -> argparse.ArgumentParser:
    """Return the parser of a word; arguments that are fields of its report have their names."""
    arguments = {"compare": "A B", "sensitivity": "PARAMETER"}
    options = "[--where KEY=VALUE ...] [--study STUDY] [options] [outputs=… tracking.uri=…]"
    parser = argparse.ArgumentParser(
        prog=f"rl-design-report {word}",
        # By itself, argparse would name the arguments after --where, which would take them for its own.
        usage=f"%(prog)s {arguments[word]} {options}" if word in arguments else None,
        description=f"Draw {WORDS[word]}, from recorded runs, into outputs/report: PNG, SVG, CSV and Markdown.",
    )
    if word == "heatmap":
        parser.add_argument("--rows", required=True, metavar="PARAMS", help="of the rows: representation,reward")
        parser.add_argument("--cols", required=True, metavar="PARAMS", help="of the columns: exploration.k")
    elif word == "curves":
        parser.add_argument("--by", required=True, metavar="PARAMS", help="parameters that make the lines")
        parser.add_argument("--curve", default="steps/mean", help="which learning curve (default: %(default)s)")
    elif word == "sensitivity":
        parser.add_argument("parameter", metavar="PARAMETER", help="such as exploration.k")
    else:
        parser.add_argument(
            "a", metavar="A", help="values of parameters, such as representation=ad_hoc; several in quotes"
        )
        parser.add_argument("b", metavar="B", help="values of the same parameters on the other side")
    if word != "curves":
        parser.add_argument("--value", default="total_steps", help=_VALUE)
    if word != "sensitivity":
        parser.add_argument("--mean", action="store_true", help="average runs that differ in more than their seed")
    parser.add_argument("--study", help="the runs of a study; all recorded runs if nothing chooses among them")
    where_help = "the runs with these values, as on the command line: exploration=linear world.size=10,20"
    parser.add_argument("--where", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=where_help)
    parser.add_argument("--filter", help="the runs that a filter of MLflow finds: \"params.reward = 'end_reward'\"")
    parser.add_argument("--title", default="", help="of the picture")
    parser.add_argument("--name", help="of the files, without suffix")
    parser.add_argument("overrides", nargs="*", help="the store with the runs: outputs=… tracking.uri=…")
    return parser


def _where(words: Sequence[str]) -> tuple[dict[str, list[Any]], list[str]]:
    """Return the values of `--where` by name, and the settings that follow them on the command line.

    Raises:
        ConfigError: a word is not KEY=VALUE, in Hydra's grammar for sweeps.
    """
    import yaml
    from hydra.core.override_parser.overrides_parser import OverridesParser

    from rl_design_space.config.overrides import is_setting
    from rl_design_space.plan.grid import axes

    if unknown := [word for word in words if "=" not in word]:
        raise ConfigError(f"--where {unknown[0]}: should be KEY=VALUE, such as exploration=linear")
    chosen = axes([word for word in words if not is_setting(word)], OverridesParser.create()) if words else {}
    where = {key: [yaml.safe_load(each.partition("=")[2]) for each in values] for key, values in chosen.items()}
    return where, list(filter(is_setting, words))


def _figure(word: str, chosen: argparse.Namespace) -> Report:
    from rl_design_space import report
    from rl_design_space.config.build import construct

    kinds: dict[str, Any] = {"heatmap": report.Heatmap, "curves": report.Curves, "sensitivity": report.Sensitivity}
    kind = kinds.get(word, report.Compare)
    names = {field.name for field in fields(kind)}
    figure: Report = construct(kind, {name: value for name, value in vars(chosen).items() if name in names})
    return figure


def _name(word: str, heading: str) -> str:
    """Return the name of the files of a heading."""
    return f"{word}-{re.sub(r'[^A-Za-z0-9.]+', '-', heading).strip('-')}"
