"""The arguments of a command line, before Hydra gets them."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from math import prod

from hydra._internal.utils import get_args_parser
from hydra.core.override_parser.types import Override, ValueType

from rl_design_space.commands import words as command_words
from rl_design_space.config import user_config
from rl_design_space.config.grammar import LOOK, parse, sweep_size
from rl_design_space.config.overrides import is_override, is_setting
from rl_design_space.errors import ConfigError, has_password, without_passwords
from rl_design_space.plan.grid import MAX_POINTS, refuse_large

_OWN_SWEEPER = "design"
#: Values that leave `study`, `plan` or `shard` unused.
_UNUSED = ("null", "false")


@dataclass(frozen=True)
class CommandLine:
    """A parsed command line.

    The overrides of a sweep apply to its points, which may choose other options than the defaults. Hydra would check
    them against the defaults, so they bypass Hydra and go to our sweeper, e.g. `study=table4 exploration.k=0.05`.

    Attributes:
        typed: all arguments but the user's config folder.
        overrides: those that are overrides.
        for_hydra: the arguments that Hydra gets.
        for_points: the overrides that apply to the points of a sweep and bypass Hydra.
        foreign: whether it runs a sweep with another sweeper than ours.
        runs: whether it runs points; False if it shows help or a configuration.
    """

    typed: tuple[str, ...] = ()
    overrides: tuple[str, ...] = ()
    for_hydra: tuple[str, ...] = ()
    for_points: tuple[str, ...] = ()
    foreign: bool = False
    runs: bool = True

    @property
    def command(self) -> str:
        """The command line as text, quoted for a shell."""
        return shlex.join(["rl-design-space", *user_config.flags(), *self.typed])


def read_command_line(arguments: Sequence[str]) -> CommandLine:
    """Parse the arguments of a command line, and check them as far as possible before Hydra composes them.

    Raises:
        ConfigError: an argument holds a password, is not an override, gives a value where an option is needed, or the
            flags and overrides contradict each other.
    """
    for argument in arguments:
        if has_password(argument):
            raise ConfigError(
                f"{without_passwords(argument)}: should not hold a password, because commands are recorded with runs; "
                "docs/server.md says where to put it"
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
    values = {override.key_or_group: (override.input_line or "").partition("=")[2] for override in parsed}
    sweeps = [f"{key}={values[key]}" for key in ("study", "plan", "shard") if values.get(key, "null") not in _UNUSED]
    sweeper = values.get("hydra/sweeper", _OWN_SWEEPER)
    if sweeper != _OWN_SWEEPER and sweeps:
        raise ConfigError(f"{sweeps[0]} needs hydra/sweeper={_OWN_SWEEPER}, not {sweeper}")
    if sweeper == "basic" and flags.multirun:  # it composes all its points before it runs any
        most = values.get("max_points", "")
        refuse_large(prod(map(_size, parsed)), int(most) if most.isdecimal() else MAX_POINTS)
    # `study=null` is the default, and Hydra does not accept it as an override.
    accepted = [override for override in flags.overrides if override != "study=null"]
    # Flags first: Hydra does not parse overrides with flags between them.
    flag_arguments = [argument for argument in arguments if argument not in flags.overrides]
    if sweeper != _OWN_SWEEPER or others or not (flags.multirun or sweeps):
        return CommandLine(
            tuple(arguments), overrides, (*flag_arguments, *accepted), foreign=flags.multirun, runs=not others
        )
    for_points = tuple(override for override in overrides if not is_setting(override))
    settings = [override for override in accepted if override not in for_points]
    implied = [] if flags.multirun or flags.run else ["--multirun"]
    return CommandLine(tuple(arguments), overrides, (*implied, *flag_arguments, *settings), for_points)


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
    return ConfigError(f"{without_passwords(word)}: not an override{hint or f'; {LOOK}'}")
