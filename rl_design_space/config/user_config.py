"""The user's config folder: find it, list what it shadows, and make modules beside it importable.

The folder is set by `--config-dir` or by an environment variable. It is kept in that variable, so that processes
started by this one, such as the workers of a cluster, use the same folder.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rl_design_space._paths import CONF
from rl_design_space.config.own_modules import import_from_source
from rl_design_space.errors import ConfigError

#: Environment variable that names the folder; the flag takes precedence.
VARIABLE = "RL_DESIGN_SPACE_CONFIG"
FLAG = "--config-dir"
#: The flag with the abbreviations that Hydra accepts.
_FLAG = re.compile(r"(--config-d(?:ir?)?|-cd)(?:=(.*))?", re.DOTALL)
#: How options of several folders are used.
_SEVERAL = "hydra.searchpath=[DIR] adds the options of other folders"


def take_flag(arguments: Sequence[str]) -> tuple[str | None, list[str]]:
    """Return the folder that the arguments name, if any, and the other arguments.

    Raises:
        ConfigError: the flag comes last, without a folder, or is given twice; Hydra's own would take the last one.
    """
    folder: str | None = None
    rest, left = [], iter(arguments)
    for argument in left:
        found = _FLAG.fullmatch(argument)
        if not found:
            rest.append(argument)
            continue
        named = found[2] if found[2] is not None else next(left, None)
        if named is None:
            raise ConfigError(f"{argument}: needs a folder, as in {FLAG} conf")
        if folder is not None:
            raise ConfigError(f"{FLAG} {folder}, {FLAG} {named}: should be given once; {_SEVERAL}")
        folder = named
    return folder, rest


def use(folder: str | Path | None = None) -> None:
    """Use a folder: its options and studies precede the shipped ones, and modules beside it can be imported.

    Args:
        folder: the folder; if None, that of the environment variable, if any.

    Raises:
        ConfigError: there is no such folder.
    """
    named = f"{FLAG} {folder}" if folder is not None else f"{VARIABLE}={os.environ.get(VARIABLE)}"
    path = _absolute(folder) if folder is not None else user_folder()
    if path is not None:
        if not path.is_dir():
            raise ConfigError(f"{named}: there is no such folder; create it with mkdir")
        os.environ[VARIABLE] = str(path)
    make_importable(module_folders())


@contextmanager
def used(folder: str | Path | None) -> Iterator[None]:
    """Use a folder inside the context, if there is one; modules beside it stay importable afterwards."""
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
    """Return the folder in use, if any."""
    named = os.environ.get(VARIABLE)
    return _absolute(named) if named else None


def _absolute(folder: str | Path) -> Path:
    """Return an absolute path without `..`; links are kept, because other machines may resolve them differently."""
    return Path(os.path.abspath(Path(folder).expanduser()))  # noqa: PTH100


def module_folders() -> list[str]:
    """Return the folders searched for user modules: the current folder, and the parent of the config folder."""
    folder = user_folder()
    return list(dict.fromkeys([str(Path.cwd()), *([str(folder.parent)] if folder else [])]))


def make_importable(folders: Sequence[str]) -> None:
    """Make modules in these folders importable, after all installed modules, so that none of them is shadowed."""
    import_from_source(folders)
    sys.path += [folder for folder in folders if folder not in sys.path]


def unused(group: str, option: str) -> Path | None:
    """Return a subfolder of the current folder that has this option and is not in use, or None."""
    folders = sorted(path for path in Path.cwd().iterdir() if path.is_dir() and path != user_folder())
    return next((folder for folder in folders if (folder / group / f"{option}.yaml").is_file()), None)


def flags() -> list[str]:
    """Return the arguments that make a command use the same folder."""
    folder = user_folder()
    return [] if folder is None else [FLAG, shown(folder)]


def shown(path: Path) -> str:
    """Return a path for messages: relative if it lies below the current folder."""
    return str(path.relative_to(Path.cwd())) if path.is_relative_to(Path.cwd()) else str(path)


def shadowing() -> list[Path]:
    """Return the user's files that replace shipped files of the same name."""
    folder = user_folder()
    if folder is None or folder.samefile(CONF):
        return []
    return sorted(path for path in folder.rglob("*.yaml") if (CONF / path.relative_to(folder)).is_file())


def tell_of_shadowing() -> None:
    """Print the user's files that replace shipped ones to stderr."""
    for path in shadowing():
        print(f"{shown(path)} is used in place of the shipped file of that name", file=sys.stderr)
