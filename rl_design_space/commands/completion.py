"""Tab completion: what may follow in a command line that is being typed."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout

from rl_design_space.config import user_config

#: A request of a shell, as the argument after `-sc`, and commands that this completes.
_QUERY = re.compile(r"query=(bash|zsh|fish)")
_PROGRAMS = _, _REPORT = "rl-design-space", "rl-design-report"
#: Words of which the first argument is something to look up.
_LOOK_UP = ("list", "show")
#: Arguments that look like overrides, and are none of Hydra's.
_OWN = ("period=", "trial=")


def answer(arguments: Sequence[str]) -> str | None:
    """Return what is printed for the arguments `-sc query=SHELL` and `-sc install=bash`; None if they are others.

    To a query, nothing else is printed, whatever happens, because the user is typing.
    """
    if len(arguments) != 2 or arguments[0] not in ("-sc", "--shell_completion"):
        return None
    if arguments[1] == "install=bash":
        return _installation()
    shell = _QUERY.fullmatch(arguments[1])
    if not shell:
        return None
    found: list[str] = []
    line = os.environ.get("COMP_LINE", "")
    try:
        with _silence():
            found = suggestions(line[: _cursor(line)])
    except (Exception, SystemExit):
        found = []
    return ("\n" if shell[1] == "fish" else " ").join(found)


def suggestions(line: str) -> list[str]:
    """Return what may be the last word of a command line, or follow it if the line ends with a space.

    Args:
        line: up to the cursor, with the name of the program.
    """
    program, *typed = line.split() or [""]
    last = "" if line[-1:].isspace() or not typed else typed.pop()
    folder, words = user_config.take_flag(typed)
    with user_config.used(folder):
        found = _report(words, last) if program.rpartition("/")[2] == _REPORT else _command(words, last)
        return sorted({name for name in found if name.startswith(last)})


def _command(words: Sequence[str], last: str) -> Iterator[str]:
    """Yield what may follow the words of `rl-design-space`."""
    from rl_design_space.commands import words as command_words
    from rl_design_space.config.overrides import is_override, is_setting

    word = words[0] if words and words[0] in command_words.names() else ""
    if not words:
        yield from command_words.names()
    if word in _LOOK_UP:
        yield from _subjects(word) if len(words) == 1 else ("--json",)
        return
    if word == "new":
        from rl_design_space.commands.words.new import KINDS

        yield from KINDS if len(words) == 1 else ()
        return
    if word == "store" and len(words) == 1:
        yield from ("status", "compact")
        return
    if word == "watch":
        from rl_design_space.analysis.snapshot import PLACES, RANKS

        yield from (*(f"period={name}" for name in RANKS), *(f"trial={name}" for name in (*PLACES, *RANKS)))
        yield "--animate"
        word = ""
    overrides = _overrides([each for each in words if is_override(each) and not each.startswith(_OWN)], last)
    yield from filter(is_setting, overrides) if word else overrides


def _subjects(word: str) -> Iterator[str]:
    """Yield what `list` or `show` describes: choices, and for `show` options and keys."""
    from rl_design_space.catalogue.keys import Keys
    from rl_design_space.catalogue.search import HYDRA_GROUPS, searched

    with searched() as search:
        groups = (*search.groups, *HYDRA_GROUPS)
        yield from groups
        if word == "show":
            yield from Keys(search).names
            yield from (f"{group}={option}" for group in groups for option in search.options(group))


def _report(words: Sequence[str], last: str) -> Iterator[str]:
    """Yield what may follow the words of `rl-design-report`: studies with a report and figures, then settings."""
    from rl_design_space.catalogue.overview import reported_studies
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import figure_arguments, look_arguments
    from rl_design_space.config.overrides import is_setting

    if not words:
        yield from (*figure_arguments.WORDS, "all")
        with searched() as search:
            yield from reported_studies(search)
        return
    if words[0] in figure_arguments.WORDS:
        if words[-1] == "--value":
            yield from figure_arguments.values()
            return
        if words[-1] == "--scale" and words[0] in figure_arguments.OWN_SCALE:
            yield from figure_arguments.scales()
            return
        if words[-1] in look_arguments.CHOICES:
            yield from look_arguments.CHOICES[words[-1]]
            return
        yield from figure_arguments.flags(words[0])
    else:
        if words[-1] in look_arguments.CHOICES:
            yield from look_arguments.CHOICES[words[-1]]
            return
        yield from ("--title", *map(look_arguments.flag_of, look_arguments.NAMES))
    yield from filter(is_setting, _overrides([], last))


def _overrides(overrides: Sequence[str], last: str) -> Iterable[str]:
    """Return what Hydra suggests after these overrides; it suggests no flags."""
    if last.startswith("-"):
        return []
    from hydra._internal.core_plugins.bash_completion import BashCompletion
    from hydra.core.global_hydra import GlobalHydra

    from rl_design_space._paths import make_plugins_known
    from rl_design_space.config.compose import CONFIG_NAME, shipped_config

    make_plugins_known()
    with shipped_config():
        return BashCompletion(GlobalHydra.instance().config_loader())._query(CONFIG_NAME, " ".join([*overrides, last]))


def _installation() -> str:
    """Return Hydra's script for bash, for both commands."""
    from hydra._internal.core_plugins.bash_completion import BashCompletion

    written = io.StringIO()
    with redirect_stdout(written):
        BashCompletion(None).install()  # type: ignore[arg-type]
    script, _, program = written.getvalue().rstrip().rpartition(" ")
    return f"{script} {' '.join(_PROGRAMS) if program in _PROGRAMS else program}"


def _cursor(line: str) -> int:
    """Return where the cursor is in the line; at its end if the shell does not tell."""
    point = os.environ.get("COMP_POINT", "")
    return int(point) if point.isdecimal() else len(line)


@contextmanager
def _silence() -> Iterator[None]:
    """Print nothing."""
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        yield
