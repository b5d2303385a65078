"""The arguments of a command line, before Hydra gets them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from math import prod

from hydra._internal.utils import get_args_parser
from hydra.core.override_parser.types import Override, ValueType

from rl_design_space._secrets import has_secret, without_secrets
from rl_design_space.commands import words as command_words
from rl_design_space.commands.intent import OWN_SWEEPERS, intent_of
from rl_design_space.config import user_config
from rl_design_space.config.grammar import LOOK, parse, sweep_size
from rl_design_space.config.overrides import is_override, shared
from rl_design_space.errors import ConfigError
from rl_design_space.plan.grid import MAX_POINTS, refuse_large


@dataclass(frozen=True)
class CommandLine:
    """A parsed command line.

    The overrides of a sweep apply to its points, which may choose other options than the defaults. Hydra composes the
    settings of the sweep, and would check them against the defaults, e.g. `study=table4 exploration.k=0.05`. So it gets
    them in another form, see `shared`.

    Attributes:
        typed: all arguments but the user's config folder.
        overrides: those that are overrides.
        for_hydra: the arguments that Hydra gets.
        foreign: whether it runs a sweep with another sweeper than ours.
        runs: whether it runs points; False if it shows help or a configuration.
        only_planned: whether it would run a single point without `plan=true`.
    """

    typed: tuple[str, ...] = ()
    overrides: tuple[str, ...] = ()
    for_hydra: tuple[str, ...] = ()
    foreign: bool = False
    runs: bool = True
    only_planned: bool = False

    @property
    def command(self) -> str:
        """The command line as text, quoted for a shell."""
        return shlex.join(["rl-design-space", *user_config.flags(), *self.typed])


def read_command_line(arguments: Sequence[str]) -> CommandLine:
    """Parse the arguments of a command line, and check them as far as possible before Hydra composes them.

    Raises:
        ConfigError: an argument holds a password or token, is not an override, gives a value where an option is needed,
            or the flags and overrides contradict each other.
    """
    for argument in arguments:
        if has_secret(argument):
            raise ConfigError(
                f"{without_secrets(argument, is_address=True)}: should not hold a password or token, because commands "
                "are recorded with runs; docs/server.md says where to put it"
            )
    flags = get_args_parser().parse_intermixed_args(arguments)
    overrides = tuple(override for override in flags.overrides if is_override(override))
    parsed = parse(overrides)

    if words := [word for word in flags.overrides if not is_override(word) and not flags.shell_completion]:
        raise _misplaced(words[0], arguments)
    others = [name for name in ("cfg", "info", "help", "hydra_help", "shell_completion") if getattr(flags, name)]
    if flags.multirun and others:
        raise ConfigError(
            f"--multirun and --{others[0].replace('_', '-')} cannot be used together; leave one of them out"
        )
    # Flags first: Hydra does not parse overrides with flags between them.
    flag_arguments = [argument for argument in arguments if argument not in flags.overrides]
    # `study=null` is the default, and Hydra does not accept it as an override.
    accepted = [override for override in parsed if override.input_line != "study=null"]
    if others:
        texts = [override for override in flags.overrides if override != "study=null"]
        return CommandLine(tuple(arguments), overrides, (*flag_arguments, *texts), runs=False)
    intent = intent_of(accepted, flags.config_name)
    multirun = flags.multirun or (intent.multirun and not flags.run)
    if not intent.own_sweeper and intent.sweeps:
        raise ConfigError(f"{intent.sweeps[0]} needs hydra/sweeper={' or '.join(OWN_SWEEPERS)}, not {intent.sweeper}")
    if intent.sweeper == "basic" and multirun:  # it composes all its points before it runs any
        given = {override.key_or_group: override.value() for override in parsed}.get("max_points")
        refuse_large(prod(map(_size, parsed)), given if isinstance(given, int) else MAX_POINTS)
    if not intent.own_sweeper or not (multirun or intent.sweeps):
        texts = [override.input_line or "" for override in accepted]
        return CommandLine(tuple(arguments), overrides, (*flag_arguments, *texts), foreign=multirun)
    implied = [] if flags.multirun or flags.run else ["--multirun"]
    only_planned = not multirun and all(text.startswith("plan=") for text in intent.sweeps)
    for_hydra = (*implied, *flag_arguments, *shared(accepted))
    return CommandLine(tuple(arguments), overrides, for_hydra, only_planned=only_planned)


def _size(override: Override) -> int:
    """Return how many values an override lists; 1 if that depends on the options there are."""
    return 1 if override.value_type == ValueType.GLOB_CHOICE_SWEEP else sweep_size(override)


def _misplaced(word: str, arguments: Sequence[str]) -> ConfigError:
    """Return an error for a word that is no override, with the command that may be meant."""
    known = command_words.names()
    if word in known:
        rest = list(arguments)
        rest.remove(word)
        # What follows the word may belong to it, so it stays before the settings.
        place = list(arguments).index(word)
        command = shlex.join(["rl-design-space", word, *rest[place:], *rest[:place]])
        return ConfigError(f"{word}: a command is the first argument, as in `{command}`")
    meant = [name for name in known if name.startswith(word)] or get_close_matches(word, known, n=1)
    hint = f"; did you mean `rl-design-space {meant[0]}`?" if meant else ""
    return ConfigError(f"{without_secrets(word)}: not an override{hint or f'; {LOOK}'}")
