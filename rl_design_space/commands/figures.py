"""`rl-design-report heatmap`, `curves`, `sensitivity`, `compare`: pictures of any recorded runs."""

from __future__ import annotations

import argparse
import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rl_design_space.config import user_config
from rl_design_space.errors import ConfigError

#: Words of the command, with what they draw.
WORDS = {
    "heatmap": "a number by two parameters, as a table of colours",
    "curves": "learning curves by the values of parameters",
    "sensitivity": "how much a number depends on one parameter",
    "compare": "two choices beside each other, all else equal, paired by period",
}


def main(word: str, arguments: Sequence[str]) -> list[Path]:
    """Draw what a word says.

    Returns:
        The files written.

    Raises:
        ConfigError: there are no such runs, or they have no such parameter or value.
    """
    chosen = _parser(word).parse_intermixed_args(arguments)
    if unknown := [word_ for word_ in chosen.overrides if "=" not in word_]:
        raise ConfigError(f"{unknown[0]}: not an override; they look like outputs=elsewhere")

    from rl_design_space.report.generic.selection import Selection
    from rl_design_space.run.settings import settings_of
    from rl_design_space.tracking.run_frame import of_newest_code

    settings = settings_of(chosen.overrides)
    reader = settings.tracking.reader()
    figure = _FIGURES[word](chosen)
    command = shlex.join(["rl-design-report", *user_config.flags(), word, *arguments])
    frame, remarks = reader.frame(chosen.study, chosen.filter), []
    if not any(".source" in argument for argument in arguments):
        every, frame = frame, of_newest_code(frame)
        if left_out := len(every) - len(frame):
            remarks = [f"Left out: {left_out} of {len(every)} runs, of components whose code was changed since."]
    selection = Selection.of_runs(frame, reader, command, remarks)
    name = chosen.name or _name(word, figure.heading)
    paths: list[Path] = figure.write_of(selection, Path(settings.outputs) / "report" / name)
    return paths


def _parser(word: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=f"rl-design-report {word}",
        description=f"Draw {WORDS[word]}, from recorded runs, into outputs/report: PNG, SVG, CSV and Markdown.",
    )
    if word == "heatmap":
        parser.add_argument("--rows", required=True, metavar="PARAMS", help="of the rows: representation,reward")
        parser.add_argument("--cols", required=True, metavar="PARAMS", help="of the columns: exploration.k")
    elif word == "curves":
        parser.add_argument("--by", required=True, metavar="PARAMS", help="parameters that make the lines")
        parser.add_argument("--curve", default="steps/mean", help="which learning curve (default: %(default)s)")
    elif word == "sensitivity":
        parser.add_argument("parameter", help="such as exploration.k")
    else:
        parser.add_argument("a", help="values of parameters, such as representation=ad_hoc; several in quotes")
        parser.add_argument("b", help="the same for the other side")
    if word != "curves":
        parser.add_argument("--value", default="total_steps", help="which scalar (default: %(default)s)")
    if word in ("heatmap", "curves"):
        parser.add_argument("--mean", action="store_true", help="average runs that differ in more than their seed")
    parser.add_argument("--study", help="the runs of a study; all recorded runs if neither this nor --filter is given")
    parser.add_argument("--filter", help="the runs that MLflow's search finds: \"params.reward = 'end_reward'\"")
    parser.add_argument("--title", default="", help="of the picture")
    parser.add_argument("--name", help="of the files, without suffix")
    parser.add_argument("overrides", nargs="*", help="where they were recorded: outputs=… tracking.uri=…")
    return parser


def _heatmap(chosen: argparse.Namespace) -> Any:
    from rl_design_space.report.generic.heatmap import Heatmap

    options = {"rows": chosen.rows, "cols": chosen.cols, "value": chosen.value}
    return Heatmap(**options, mean=chosen.mean, title=chosen.title)


def _curves(chosen: argparse.Namespace) -> Any:
    from rl_design_space.report.generic.curves import Curves

    return Curves(by=chosen.by, curve=chosen.curve, mean=chosen.mean, title=chosen.title)


def _sensitivity(chosen: argparse.Namespace) -> Any:
    from rl_design_space.report.generic.sensitivity import Sensitivity

    return Sensitivity(parameter=chosen.parameter, value=chosen.value, title=chosen.title)


def _compare(chosen: argparse.Namespace) -> Any:
    from rl_design_space.report.generic.compare import Compare

    return Compare(a=chosen.a, b=chosen.b, value=chosen.value, title=chosen.title)


_FIGURES: Mapping[str, Callable[[argparse.Namespace], Any]] = {
    "heatmap": _heatmap,
    "curves": _curves,
    "sensitivity": _sensitivity,
    "compare": _compare,
}


def _name(word: str, heading: str) -> str:
    """A file's name from a heading."""
    return f"{word}-{re.sub(r'[^A-Za-z0-9.]+', '-', heading).strip('-')}"
