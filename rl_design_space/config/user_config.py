"""A config folder of the user's own: where it is, what it shadows, and that modules beside it can be imported.

It is named by `--config-dir` or by the environment variable, which is where it is kept: processes that are started by
this one, such as the workers of a cluster, find it there.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rl_design_space._paths import CONF
from rl_design_space.errors import ConfigError

#: Names the folder; the flag does, too, and goes before it.
VARIABLE = "RL_DESIGN_SPACE_CONFIG"
FLAG = "--config-dir"
#: The flag as Hydra understands it, abbreviations included.
_FLAG = re.compile(r"(--config-d(?:ir?)?|-cd)(?:=(.*))?", re.DOTALL)


def take_flag(arguments: Sequence[str]) -> tuple[str | None, list[str]]:
    """The folder that a command line names, and the rest of it.

    Raises:
        ConfigError: the flag stands last, without a folder.
    """
    folder, rest, left = None, [], iter(arguments)
    for argument in left:
        found = _FLAG.fullmatch(argument)
        if not found:
            rest.append(argument)
        elif found[2] is not None:
            folder = found[2]
        elif (folder := next(left, None)) is None:
            raise ConfigError(f"{argument}: needs a folder, as in {FLAG} conf")
    return folder, rest


def use(folder: str | Path | None = None) -> None:
    """Look for options and studies in a folder before the shipped ones, and for modules beside it.

    Args:
        folder: the folder; if None, the one that the environment names, if any.

    Raises:
        ConfigError: there is no such folder.
    """
    named = f"{FLAG} {folder}" if folder is not None else f"{VARIABLE}={os.environ.get(VARIABLE)}"
    path = _absolute(folder) if folder is not None else user_folder()
    if path is not None:
        if not path.is_dir():
            raise ConfigError(f"{named}: there is no such folder; mkdir makes one")
        os.environ[VARIABLE] = str(path)
    make_importable(module_folders())


@contextmanager
def used(folder: str | Path | None) -> Iterator[None]:
    """The same for a while, if there is a folder; modules beside it can be imported from then on."""
    if folder is None and user_folder() is None:
        yield
        return
    before = os.environ.get(VARIABLE)
    try:
        use(folder)
        yield
    finally:
        os.environ.pop(VARIABLE, None)
        if before is not None:
            os.environ[VARIABLE] = before


def user_folder() -> Path | None:
    """The folder in use, if any."""
    named = os.environ.get(VARIABLE)
    return _absolute(named) if named else None


def _absolute(folder: str | Path) -> Path:
    """Without `..`, and with the links that the user sees: other machines may mount what lies behind them elsewhere."""
    return Path(os.path.abspath(Path(folder).expanduser()))  # noqa: PTH100


def module_folders() -> list[str]:
    """Where modules of the user's own are looked for: the current folder, and the one that holds the config folder."""
    folder = user_folder()
    return list(dict.fromkeys([str(Path.cwd()), *([str(folder.parent)] if folder else [])]))


def make_importable(folders: Sequence[str]) -> None:
    """Let modules in these folders be imported; those that are installed go first, so that nothing shadows them."""
    sys.path += [folder for folder in folders if folder not in sys.path]


def unused(group: str, option: str) -> Path | None:
    """A folder in the current one that has this option, and was not named; None if there is none."""
    folders = sorted(path for path in Path.cwd().iterdir() if path.is_dir() and path != user_folder())
    return next((folder for folder in folders if (folder / group / f"{option}.yaml").is_file()), None)


def flags() -> list[str]:
    """What a command needs so that it finds the folder in use."""
    folder = user_folder()
    return [] if folder is None else [FLAG, shown(folder)]


def shown(path: Path) -> str:
    """A path as one would type it: relative if it lies below the current folder."""
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)


def shadowing() -> list[Path]:
    """The user's files that are taken in place of shipped ones of the same name."""
    folder = user_folder()
    if folder is None or folder.samefile(CONF):
        return []
    return sorted(path for path in folder.rglob("*.yaml") if (CONF / path.relative_to(folder)).is_file())


def tell_of_shadowing() -> None:
    """Say on stderr which of the user's files are taken in place of shipped ones."""
    for path in shadowing():
        print(f"{shown(path)} is used in place of the shipped file of that name", file=sys.stderr)
