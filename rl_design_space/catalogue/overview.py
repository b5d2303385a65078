"""What `rl-design-space --help` says: what to type first, the commands, the choices, and where there is more."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from textwrap import TextWrapper

from rl_design_space.catalogue.comments import first_sentence, leading_comment
from rl_design_space.catalogue.search import Search

_WIDTH = 120
_INTRODUCTION = """\
Maps the design space of a reinforcement-learning problem: runs design points, each once, and records their learning
curves in MLflow. KEY=VALUE overrides what the config files say."""

_FIRST = {
    "rl-design-space list": "what there is to choose from",
    "rl-design-space show exploration=linear": "what an option takes: types, ranges, defaults",
    "rl-design-space show study=table4": "what a study is made of",
    "rl-design-space study=table4 plan=true": "what it would run, and how long that takes",
    "rl-design-space study=table4": "run it; the same again goes on where this one stopped",
    "rl-design-report table4": "its tables and figures, into outputs/report",
    "rl-design-space": "one design point, the default",
    "rl-design-space representation=direction world.size=20": "one that is chosen otherwise",
    "rl-design-space -m world.size=10,20 'seed=range(0,5)'": "a sweep: all combinations",
}
_MORE = {
    "rl-design-space --cfg job KEY=VALUE …": "the whole configuration, without running it",
    "rl-design-space --config-dir DIR …": "with options and studies of your own in DIR",
    "rl-design-space --hydra-help": "the flags and options of Hydra",
    'eval "$(rl-design-space -sc install=bash)"': "tab completion",
    "HYDRA_FULL_ERROR=1 rl-design-space …": "tracebacks of errors",
}


def overview(search: Search, commands: Mapping[str, str]) -> str:
    """The whole text.

    Args:
        search: finds the options.
        commands: what the words beside running points do.
    """
    choices = {group: ", ".join(_default_first(search, group)) for group in search.groups}
    sections = {
        "What to type first": _FIRST,
        "Commands, as in rl-design-space COMMAND --help": commands,
        "Choices, as in CHOICE=OPTION; the default comes first, but there is no study unless one is named": choices,
        "More": _MORE,
    }
    listed = ["\n".join((f"{title}:", *columns(rows))) for title, rows in sections.items()]
    return "\n\n".join((_INTRODUCTION, *listed)) + "\n"


def study_list(search: Search) -> list[str]:
    """The studies that have a report, and what each is, in two columns."""
    texts = {name: search.text(f"study/{name}") for name in search.options("study")}
    reported = {name: text for name, text in texts.items() if re.search(r"^report:", text, re.MULTILINE)}
    return list(columns({name: first_sentence(leading_comment(text)) for name, text in reported.items()}))


def _default_first(search: Search, group: str) -> list[str]:
    options = search.options(group)
    return sorted(options, key=lambda option: option != search.defaults.get(group))


def columns(rows: Mapping[str, str]) -> Iterator[str]:
    """Names and what is said of them, in two columns."""
    width = max(map(len, rows), default=0)
    for name, said in rows.items():
        beginning = f"  {name:<{width}}  "
        wrapper = TextWrapper(_WIDTH, initial_indent=beginning, subsequent_indent=" " * len(beginning))
        yield from wrapper.wrap(said) or [beginning.rstrip()]
