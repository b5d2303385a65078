"""Compiling with Numba, and caching compiled code on disk.

Numba's own cache does not detect changes of functions in other files, lets processes that compile at the same time
overwrite each other's files, runs whatever a corrupted file holds, and aborts the program if its folder cannot be used.
Therefore compiled code is cached in files named by a digest of everything that it depends on, so that it is never
outdated, and each file begins with a digest of its content.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any
from uuid import uuid4

import numba
from numba import njit
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

_DIGEST_SIZE = hashlib.sha256().digest_size
#: Decorator of functions that are called so rarely that they need not be inlined.
compiled = njit(nogil=True, error_model="numpy")
#: Options that Numba's annotations do not know. Without wrappers, a function is compiled in less time, and must not be
#: called from Python.
_UNWRAPPED: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
#: Decorator of functions that are inlined into the loop that calls them.
inlined = njit(**{**_UNWRAPPED, "forceinline": True})
#: Decorator of functions that allocate nothing, so that references to arrays need not be counted in them.
uncounted = njit(**{**_UNWRAPPED, "_nrt": False})


def compiled_and_kept(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function when it is first called, or load the code that an earlier process has compiled.

    If the cache cannot be used, there is one warning, and every process compiles for itself.
    """
    dispatcher: Any = compiled(function)
    if hasattr(dispatcher, "_cache"):  # missing if compiling is switched off
        try:
            dispatcher._cache = _Kept(function)
        except (OSError, RuntimeError) as error:
            _warn_of_cache(error)
    kept: Callable[..., Any] = dispatcher
    return kept


@contextmanager
def compile_timer() -> Iterator[Callable[[], float]]:
    """Give a function that returns the seconds of compiling inside the context, by all threads together.

    Loading compiled code does not count. Numba compiles one function at a time.
    """
    with event.install_listener("numba:compile", event.TimingListener()) as timer:
        yield lambda: float(timer.duration) if timer.done else 0.0


class _Kept(FunctionCache):
    """One file for each combination of argument types, processor, source code, and version of Numba and Python."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        target_context.refresh()
        path = self._path(sig, target_context)
        try:
            code = unsealed(path.name, path.read_bytes())
            return self._impl.rebuild(target_context, pickle.loads(code))
        except FileNotFoundError:
            return None
        except CorruptedError:
            return _warn(f"{path} is corrupted (checksum mismatch); its code is compiled again")
        except Exception as error:
            return _warn_of_cache(error)

    def save_overload(self, sig: Any, data: Any) -> None:
        try:
            path = self._path(sig, data.target_context)
            path.parent.mkdir(parents=True, exist_ok=True)
            _write(path, sealed(path.name, dumps(self._impl.reduce(data))))
            for other in path.parent.glob(f"{self._prefix}.*.nbc"):
                if not other.name.startswith(f"{self._prefix}.{source_digest()}."):
                    other.unlink(missing_ok=True)
        except OSError as error:
            _warn_of_cache(error)

    @property
    def _prefix(self) -> str:
        return f"{self._py_func.__module__}.{self._py_func.__qualname__}"

    def _path(self, sig: Any, target_context: Any) -> Path:
        parts = (self._index_key(sig, target_context.codegen()), numba.__version__, sys.implementation.cache_tag)
        key = hashlib.sha256(repr(parts).encode()).hexdigest()[:16]
        return Path(self.cache_path) / f"{self._prefix}.{source_digest()}.{key}.nbc"


@cache
def source_digest() -> str:
    """Return a digest of all source files of compiled code, those of this folder and below."""
    found = hashlib.sha256()
    folder = Path(__file__).parent
    for path in sorted(folder.rglob("*.py")):
        found.update(str(path.relative_to(folder)).encode() + path.read_bytes())
    return found.hexdigest()[:16]


class CorruptedError(Exception):
    """A file is not what was written under its name."""


def sealed(name: str, code: bytes) -> bytes:
    """Return the content of a file: a digest of its name and of the code, and the code."""
    return hashlib.sha256(name.encode() + code).digest() + code


def unsealed(name: str, content: bytes) -> bytes:
    """Return the code in the content of a file.

    Raises:
        CorruptedError: the digest does not match. One wrong bit in machine code may crash the process.
    """
    code = content[_DIGEST_SIZE:]
    if sealed(name, code) != content:
        raise CorruptedError(name)
    return code


def _write(path: Path, content: bytes) -> None:
    """Write a file so that it is there completely or not at all."""
    unfinished = path.with_name(f"{path.name}.{uuid4().hex}")
    try:
        unfinished.write_bytes(content)
        unfinished.replace(path)
    except BaseException:
        unfinished.unlink(missing_ok=True)
        raise


@cache
def _warnings_given() -> list[str]:
    return []


def _warn_of_cache(reason: Exception) -> None:
    """Warn that compiled code is not cached or cannot be loaded."""
    _warn(
        f"compiled code cannot be cached or loaded ({reason!r}); it is compiled again, which takes some seconds at "
        "every start. Set the environment variable NUMBA_CACHE_DIR to a folder that can be written to."
    )


def _warn(message: str) -> None:
    """Warn, once in a process."""
    if not _warnings_given():
        _warnings_given().append(message)
        warnings.warn(message, RuntimeWarning, stacklevel=3)
