"""Import user modules from their source, never from a bytecode file.

Python uses a bytecode file if it names the size and the modification time, in whole seconds, of the source file. So a
file that is edited within a second and keeps its size may run as it was before. The identity of a component is a digest
of its source, and must be that of the code that runs.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.machinery import (
    BYTECODE_SUFFIXES,
    EXTENSION_SUFFIXES,
    SOURCE_SUFFIXES,
    ExtensionFileLoader,
    FileFinder,
    SourceFileLoader,
    SourcelessFileLoader,
)
from importlib.util import decode_source
from pathlib import Path
from types import CodeType

from rl_design_space.errors import ConfigError

_PACKAGE = str(Path(__file__).parents[1])
_LOADERS = (ExtensionFileLoader, EXTENSION_SUFFIXES), (SourcelessFileLoader, BYTECODE_SUFFIXES)


class _SourceLoader(SourceFileLoader):
    """Compiles a module at every import, and keeps the source that it has compiled."""

    source: bytes

    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        self.source = self.get_data(path)
        code: CodeType = self.source_to_code(self.source, path)
        return code


class _Hook:
    """An entry of `sys.path_hooks` for modules that are found in these folders or below them.

    Modules below a folder that belong to another entry of `sys.path`, such as that of a virtual environment, are left
    to Python, as is this package.
    """

    def __init__(self) -> None:
        self.folders: set[str] = set()

    def __call__(self, path: str) -> FileFinder:
        entries = {*sys.path, *self.folders}
        nearest = next((str(part) for part in (Path(path), *Path(path).parents) if str(part) in entries), None)
        if nearest not in self.folders or _is_within(path, _PACKAGE) or not Path(path).is_dir():
            raise ImportError(path)
        return FileFinder(path, (_SourceLoader, SOURCE_SUFFIXES), *_LOADERS)


def import_from_source(folders: Sequence[str]) -> None:
    """Import modules in these folders, and in packages there, from their source from now on."""
    hook = next((found for found in sys.path_hooks if isinstance(found, _Hook)), None)
    if hook is None:
        hook = _Hook()
        sys.path_hooks.insert(0, hook)
    new = set(folders) - hook.folders
    hook.folders |= new
    for path in list(sys.path_importer_cache):
        if any(_is_within(path, folder) for folder in new):
            del sys.path_importer_cache[path]


def source_of(module: str, file: Path) -> str:
    """Return the source of a module: that which was imported, or the content of the file if it was not imported yet.

    Raises:
        ConfigError: Python has imported the module from an outdated bytecode file.
    """
    loader = getattr(getattr(sys.modules.get(module), "__spec__", None), "loader", None)
    if isinstance(loader, _SourceLoader):
        return decode_source(loader.source)
    source = file.read_bytes()
    if type(loader) is SourceFileLoader and _runs_another(loader, source):
        raise ConfigError(
            f"{file}: was edited within a second, and Python has imported an earlier version from its bytecode file; "
            "save the file again, and repeat the command"
        )
    return decode_source(source)


def _runs_another(loader: SourceFileLoader, source: bytes) -> bool:
    """Return whether Python finds other code for a module than that of its source."""
    try:
        return loader.get_code(loader.name) != loader.source_to_code(source, loader.path)
    except SyntaxError:
        return False


def _is_within(path: str, folder: str) -> bool:
    return Path(path).is_relative_to(folder)
