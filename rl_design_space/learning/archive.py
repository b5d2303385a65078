"""The file format of results: named arrays in an .npz file; equal arrays give equal bytes."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

#: Of zlib: on learning curves, the default level takes four times as long to save another 4 % of space.
_LEVEL = 1

Arrays = Mapping[str, NDArray[Any]]


def write_arrays(file: Path | BinaryIO, arrays: Arrays, *, compress: bool = True) -> None:
    """Write named arrays to a file.

    Args:
        file: path or open file.
        arrays: arrays by name.
        compress: whether to spend processor time on a smaller file.
    """
    method = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            member = BytesIO()
            np.save(member, array)
            # Without a time stamp, so that equal results are equal files.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), member.getbuffer(), method, _LEVEL)


def read_arrays(file: Path | BinaryIO) -> dict[str, NDArray[Any]]:
    """Return all arrays of a file by name."""
    with np.load(file) as archive:
        return {name: archive[name] for name in archive.files}
