"""The source of a module and of the modules that it imports from its folder, read without importing them."""

from __future__ import annotations

import ast
import io
import sysconfig
import tokenize
from collections.abc import Iterator
from importlib.util import resolve_name
from pathlib import Path

from rl_design_space.config.own_modules import source_of

_PACKAGE = "rl_design_space"


def modules_beside(name: str, file: Path) -> dict[str, Path]:
    """Return the files of a module and of all modules that it imports, directly or not, from its folder or below.

    The folder of `mine` and of `mine.parts.walls` is the one that holds `mine`. If it is where packages are
    installed, only modules of the same package are included. Imports inside functions count; imports by a computed name
    do not.

    Returns:
        Files by the name of their module.

    Raises:
        ConfigError: Python has imported one of them from an outdated bytecode file.
    """
    folder = file.parents[name.count(".") + (file.name == "__init__.py")]
    only = name.partition(".")[0] if _is_installed(folder) else None
    found: dict[str, Path] = {}
    left = [(name, file)]
    while left:
        module, path = left.pop()
        if module in found:
            continue
        found[module] = path
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        for imported in _imported(source_of(module, path), package):
            top = imported.partition(".")[0]
            source = _file_of(imported, folder)
            if source and top != _PACKAGE and only in (None, top):
                left.append((imported, source))
    return found


def code(source: str) -> str:
    """Return a source without comments and blank lines; string literals are left unchanged."""
    lines: list[str | None] = [*source.split("\n")]
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(source).readline))
    except (SyntaxError, tokenize.TokenError):
        return source
    for token in tokens:
        row, column = token.start[0] - 1, token.start[1]
        if token.type == tokenize.COMMENT:
            lines[row] = (lines[row] or "")[:column].rstrip()
        if token.type == tokenize.NL and not (lines[row] or "").strip():
            lines[row] = None
    return "\n".join(line for line in lines if line is not None).rstrip("\n")


def _imported(source: str, package: str) -> Iterator[str]:
    """Yield names that a source imports; some may be names of attributes of a module."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (node.module or "")
            try:
                base = resolve_name(base, package)
            except ImportError:  # a relative import beyond the top-level package
                continue
            names = [base, *(f"{base}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            parts = name.split(".")
            yield from (".".join(parts[:count]) for count in range(1, len(parts) + 1))


def _file_of(name: str, folder: Path) -> Path | None:
    """Return the source file of a module in a folder, or None if the folder has none."""
    place = folder.joinpath(*name.split("."))
    return next((path for path in (place / "__init__.py", place.with_name(f"{place.name}.py")) if path.is_file()), None)


def _is_installed(folder: Path) -> bool:
    return str(folder) in {sysconfig.get_path(name) for name in ("purelib", "platlib", "stdlib")} or folder.name in (
        "site-packages",
        "dist-packages",
    )
