"""The text of `rl-design-space --help`: first commands, all commands, the choices, and where to find more."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from textwrap import TextWrapper

from rl_design_space.catalogue.comments import first_sentence, leading_comment
from rl_design_space.catalogue.search import Search

_WIDTH = 120
_INTRODUCTION = """\
Maps the design space of a reinforcement-learning problem: runs design points, each once, and records their learning
curves in MLflow. KEY=VALUE overrides the value in the config files."""

_FIRST = {
    "rl-design-space list": "list all choices and their options",
    "rl-design-space show exploration=linear": "show the parameters of an option: types, ranges, defaults",
    "rl-design-space show study=table4": "show the blocks and points of a study",
    "rl-design-space study=table4 plan=true": "show what it would run, and how long that takes",
    "rl-design-space study=table4": "run it; the same command resumes an interrupted run",
    "rl-design-report table4": "write its tables and figures to outputs/report",
    "rl-design-space": "run one design point, the default",
    "rl-design-space representation=direction world.size=20": "run another design point",
    "rl-design-space -m world.size=10,20 'seed=range(0,5)'": "run a sweep: all combinations",
}
_MORE = {
    "rl-design-space --cfg job KEY=VALUE …": "print the whole configuration, without running it",
    "rl-design-space --config-dir DIR …": "use options and studies of your own in DIR",
    "rl-design-space --hydra-help": "show the flags and options of Hydra",
    'eval "$(rl-design-space -sc install=bash)"': "enable tab completion",
    "HYDRA_FULL_ERROR=1 rl-design-space …": "show tracebacks of errors",
}


def overview(search: Search, commands: Mapping[str, str]) -> str:
    """Return the help text.

    Args:
        search: where to find the options.
        commands: summary of each command.
    """
    choices = {group: ", ".join(_default_first(search, group)) for group in search.groups}
    sections = {
        "First commands": _FIRST,
        "Commands, as in rl-design-space COMMAND --help": commands,
        "Choices, as in CHOICE=OPTION; the default comes first, and by default there is no study": choices,
        "More": _MORE,
    }
    listed = ["\n".join((f"{title}:", *columns(rows))) for title, rows in sections.items()]
    return "\n\n".join((_INTRODUCTION, *listed)) + "\n"


def study_list(search: Search) -> list[str]:
    """Return the studies that have a report with their descriptions, in two columns."""
    reported = reported_studies(search)
    return list(columns({name: first_sentence(leading_comment(text)) for name, text in reported.items()}))


def reported_studies(search: Search) -> dict[str, str]:
    """Return the text of each study's file that describes a report, by the name of the study."""
    texts = {name: search.text(f"study/{name}") for name in search.options("study")}
    return {name: text for name, text in texts.items() if re.search(r"^report:", text, re.MULTILINE)}


def _default_first(search: Search, group: str) -> list[str]:
    options = search.options(group)
    return sorted(options, key=lambda option: option != search.defaults.get(group))


def columns(rows: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of names and descriptions in two columns."""
    width = max(map(len, rows), default=0)
    for name, description in rows.items():
        beginning = f"  {name:<{width}}  "
        wrapper = TextWrapper(_WIDTH, initial_indent=beginning, subsequent_indent=" " * len(beginning))
        yield from wrapper.wrap(description) or [beginning.rstrip()]
