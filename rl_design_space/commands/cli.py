"""The command `rl-design-space`."""

from __future__ import annotations

import sys

from rl_design_space._paths import make_plugins_known
from rl_design_space._version import __version__
from rl_design_space.commands.interrupts import end_quickly, handle_interrupts
from rl_design_space.commands.messages import shown_as_messages
from rl_design_space.config import user_config


def main() -> None:
    """Run the command; errors that a user can fix are shown as one message, with exit status 2.

    Everything that takes time to import is imported inside, where an interrupt is no traceback.
    """
    handle_interrupts()
    end_quickly()
    with shown_as_messages():
        from rl_design_space.commands import completion, words

        if (completed := completion.answer(sys.argv[1:])) is not None:
            print(completed)
            return
        folder, arguments = user_config.take_flag(sys.argv[1:])
        user_config.use(folder)
        if arguments[:1] and arguments[0] in words.names():
            words.run(arguments[0], arguments[1:])
        elif "--version" in arguments:
            print(f"rl-design-space {__version__}")
        elif {"-h", "--help"} & set(arguments):
            _show_help(arguments)
        else:
            _run(arguments)


def _run(arguments: list[str]) -> None:
    """Run points, or show a configuration.

    Raises:
        ConfigError: the arguments contradict each other, or select no point.
        SystemExit: with status 1 if a point failed or records are pending.
    """
    from rl_design_space.commands.application import application
    from rl_design_space.commands.command_line import read_command_line
    from rl_design_space.commands.invocation import Invocation, running
    from rl_design_space.config.search_path import look_in_user_folder_first

    make_plugins_known()
    line = read_command_line(arguments)
    if line.runs:
        user_config.tell_of_shadowing()
    look_in_user_folder_first()
    _share_config_store()
    sys.argv[1:] = line.for_hydra
    with running(Invocation(line)) as invocation:
        application()
    if line.foreign and not invocation.jobs:
        # Either the sweep is empty, or its launcher runs the jobs in other processes.
        from rl_design_space.commands.foreign_sweep import refuse_empty_sweep

        refuse_empty_sweep(line)
    if invocation.failed:
        sys.exit(1)


def _show_help(arguments: list[str]) -> None:
    """Print the help without composing a configuration; `--cfg job` shows a composed one."""
    from hydra._internal.utils import get_args_parser

    from rl_design_space.catalogue.overview import overview
    from rl_design_space.catalogue.search import searched
    from rl_design_space.commands import words
    from rl_design_space.config.overrides import is_search_path

    overrides = get_args_parser().parse_intermixed_args(arguments).overrides
    with searched(searchpath=list(filter(is_search_path, overrides))) as search:
        print(overview(search, words.summaries()), end="")


def _share_config_store() -> None:
    """Make Hydra share its store of built-in options, which it copies about a hundred times for `--help` otherwise.

    The store does not change once the plugins are loaded, and Hydra copies what it reads from it anyway.
    """
    from hydra.core.config_store import ConfigStore

    ConfigStore.__deepcopy__ = lambda self, _: self  # type: ignore[attr-defined]
