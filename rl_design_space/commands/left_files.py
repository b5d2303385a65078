"""Files of earlier reports that are left beside new ones, which have other numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rl_design_space.commands.messages import tell

#: Formats by the suffix of their files, as `--format` names them.
_FORMATS = {".pdf": "pdf", ".tex": "latex"}


def tell_of_left(written: Sequence[Path], left: Sequence[Path]) -> None:
    """Print which files are older than those just written, and how to write all of them anew, in one line.

    Args:
        written: the new files.
        left: the older ones.
    """
    if not left:
        return
    folder = left[0].parent
    names = [str(left[0]), *(path.name if path.parent == folder else str(path) for path in left[1:])]
    suffixes = {path.suffix for path in (*written, *left)}
    formats = " ".join(name for suffix, name in _FORMATS.items() if suffix in suffixes)
    which = "it" if len(left) == 1 else "them"
    tell(f"{', '.join(names)}: left from an earlier report; --format {formats} writes {which} anew")
