"""Arguments of the figure words of `rl-design-report`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from rl_design_space.commands.arguments import Parser
from rl_design_space.commands.look_arguments import NAMES, add_look
from rl_design_space.errors import ConfigError

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
    "importance": "how much of the variance is due to each choice, and to pairs of them",
    "best": "which designs cannot be told from the best, and how much each could lose",
    "interactions": "the effect of one choice at each value of another",
    "profile": "in how many layouts each design is how near the optimum",
    "failures": "how the failed trials of heavy tails end, and whether the representation could do better",
    "explore": "any runs as a page, in which rows, columns, values and filters are chosen",
}
#: Words that take --given, and words whose files have their name.
BY_WORD = ("importance", "best", "interactions", "profile")
NAMED = (*BY_WORD, "failures", "explore")
#: Words whose `--scale` is what a period counts as.
OWN_SCALE = ("importance", "interactions")
#: Files that words write.
_FILES, _USUAL_FILES = {"explore": "one HTML file that needs no network"}, "PNG, SVG, CSV and Markdown"
_SCALE = (
    "what a period counts as: log_over_optimum, over_optimum, log_steps, or a measure such as steps_after=30 "
    "(default: %(default)s)"
)


def flags(word: str) -> list[str]:
    """Return the flags of a word."""
    return [flag for action in _parser(word)._actions for flag in action.option_strings if flag.startswith("--")]


def values() -> list[str]:
    """Return what may follow `--value`: scalars, and measures with their usual parameters."""
    from rl_design_space.learning.measures import ONLY_SCALARS, forms

    return [*forms(), *ONLY_SCALARS]


def scales() -> list[str]:
    """Return what may follow `--scale`."""
    from rl_design_space.analysis.scales import SCALES
    from rl_design_space.learning.measures import forms

    return [*SCALES, *forms()]


def _parser(word: str) -> Parser:
    """Return the parser of a word; arguments that are fields of its report have their names."""
    arguments = {"compare": "A B", "sensitivity": "PARAMETER", "interactions": "[A B]"}
    options = "[--where KEY=VALUE ...] [--study STUDY] [options] [outputs=… tracking.uri=…]"
    parser = Parser(
        prog=f"rl-design-report {word}",
        # By itself, argparse would name the arguments after --where, which would take them for its own.
        usage=f"%(prog)s {arguments[word]} {options}" if word in arguments else None,
        description=f"Draw {WORDS[word]}, from recorded runs, into outputs/report: {_FILES.get(word, _USUAL_FILES)}.",
    )
    _add_own(parser, word)
    parser.add_argument("--study", help="the runs of a study; all recorded runs if nothing chooses among them")
    where_help = "the runs with these values, as on the command line: exploration=linear world.size=10,20"
    parser.add_argument("--where", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=where_help)
    parser.add_argument("--filter", help="the runs that a filter of MLflow finds: \"params.reward = 'end_reward'\"")
    parser.add_argument("--title", default="", help="of the picture")
    parser.add_argument("--name", help="of the files, without suffix")
    add_look(parser, look_names(word))
    parser.add_argument("overrides", nargs="*", help="the store with the runs: outputs=… tracking.uri=…")
    return parser


def _add_own(parser: argparse.ArgumentParser, word: str) -> None:
    """Add the arguments that are those of one word."""
    if word == "heatmap":
        parser.add_argument("--rows", required=True, metavar="PARAMS", help="of the rows: representation,reward")
        parser.add_argument("--cols", required=True, metavar="PARAMS", help="of the columns: exploration.k")
    elif word == "curves":
        parser.add_argument("--by", required=True, metavar="PARAMS", help="parameters that make the lines")
        parser.add_argument("--curve", default="steps/mean", help="which learning curve (default: %(default)s)")
    elif word == "sensitivity":
        parser.add_argument("parameter", metavar="PARAMETER", help="such as exploration.k")
    elif word == "compare":
        parser.add_argument(
            "a", metavar="A", help="values of parameters, such as representation=ad_hoc; several in quotes"
        )
        parser.add_argument("b", metavar="B", help="values of the same parameters on the other side")
    elif word == "interactions":
        parser.add_argument(
            "choice", nargs="?", default="", metavar="A", help="such as msa; the strongest interactions if missing"
        )
        parser.add_argument(
            "other", nargs="?", default="", metavar="B", help="the choice at whose values it is looked at"
        )
    elif word == "best":
        parser.add_argument("--statistic", default="mean", help="mean, median, iqm or cvar=5 (default: %(default)s)")
    elif word == "profile":
        parser.add_argument("--designs", type=int, default=8, help="how many designs are drawn (default: %(default)s)")
    elif word == "failures":
        tail_help = "percentage of the periods that make the tail (default: %(default)s)"
        parser.add_argument("--tail", type=float, default=5.0, help=tail_help)
        most_help = "periods of a tail that are learned again, at most (default: %(default)s)"
        parser.add_argument("--most", type=int, default=100, help=most_help)
    elif word == "explore":
        values_help = "measures that are shown beside the scalars: steps_after=30 near_share=1.1"
        parser.add_argument("--values", nargs="+", action="extend", default=[], metavar="MEASURE", help=values_help)
        curves_help = "learning curves (default: steps/mean success_rate)"
        parser.add_argument("--curves", nargs="+", action="extend", default=[], metavar="CURVE", help=curves_help)
        parser.add_argument(
            "--ui", default="http://127.0.0.1:5000", help="MLflow's UI, for links (default: %(default)s)"
        )
    _add_shared(parser, word)


def _add_shared(parser: argparse.ArgumentParser, word: str) -> None:
    """Add the arguments that some words share."""
    if word in OWN_SCALE:
        parser.add_argument("--scale", default="log_over_optimum", help=_SCALE)
    if word in BY_WORD:
        given_help = "only designs with these values: representation=direction"
        parser.add_argument("--given", nargs="+", action="extend", default=[], metavar="KEY=VALUE", help=given_help)
    if word in ("sensitivity", "compare"):
        what = "line" if word == "sensitivity" else "pair"
        named_help = f"{what}s that are shown by name if there are many: 'reward=end_reward msa=none'"
        parser.add_argument("--named", nargs="+", action="extend", default=[], metavar="VALUES", help=named_help)
        top_help = f"how many {what}s are listed, the largest effects first (default: %(default)s)"
        parser.add_argument("--top", type=int, default=20, help=top_help)
    if word in ("heatmap", "sensitivity", "compare", "best"):
        parser.add_argument("--value", default="total_steps", help=_VALUE)
    if word in ("heatmap", "curves", "compare"):
        parser.add_argument("--mean", action="store_true", help="average runs that differ in more than their seed")


def look_names(word: str) -> tuple[str, ...]:
    """Return the names of the arguments of a word that say how it looks; some words have a scale of their own."""
    if word == "explore":
        return ("labels", "order", "scale", "colour_map")
    return tuple(name for name in NAMES if not (name == "scale" and word in OWN_SCALE))


def parsed(word: str, arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a word.

    Raises:
        ConfigError: one choice is named where two are needed.
    """
    chosen = _parser(word).parse_intermixed_args(arguments)
    if word == "interactions":
        _sort_choices(chosen)
    return chosen


def _sort_choices(chosen: argparse.Namespace) -> None:
    """Move settings among the names of choices to the other settings.

    Raises:
        ConfigError: one choice is named instead of two or none.
    """
    names = [each for each in (chosen.choice, chosen.other) if each and "=" not in each]
    chosen.overrides = [*(each for each in (chosen.choice, chosen.other) if "=" in each), *chosen.overrides]
    if len(names) == 1:
        other = "representation" if names[0] == "reward" else "reward"
        raise ConfigError(
            f"{names[0]}: needs a second choice, as in `rl-design-report interactions {names[0]} {other}`"
        )
    chosen.choice, chosen.other = names or ("", "")
