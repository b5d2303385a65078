"""The file format of results: named arrays in an .npz file; equal arrays give equal bytes."""

from __future__ import annotations

import math
import struct
import zipfile
import zlib
from collections.abc import Mapping
from contextlib import nullcontext
from functools import lru_cache
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

#: Of zlib: on learning curves, the default level takes four times as long to save another 4 % of space.
_LEVEL = 1
#: First bytes of an .npy file of version 1, and length of what its header follows, the last two its length.
_VERSION_1, _FIRST = b"\x93NUMPY\x01\x00", 10
#: What precedes a member in a .zip file; the last two numbers are the lengths of its name and of extras.
_LOCAL = struct.Struct("<4s5H3L2H")

Arrays = Mapping[str, NDArray[Any]]


def write_arrays(file: Path | BinaryIO, arrays: Arrays, *, compress: bool = True) -> None:
    """Write named arrays to a file.

    Args:
        file: path or open file.
        arrays: arrays by name.
        compress: whether to spend processor time on a smaller file.

    Raises:
        ValueError: an array holds Python objects.
    """
    method = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            # Without a time stamp, so that equal results are equal files.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), _member(array), method, _LEVEL)


def read_arrays(file: Path | BinaryIO) -> dict[str, NDArray[Any]]:
    """Return all arrays of a file by name; `np.load` takes three times as long, mostly for equal headers.

    Raises:
        ValueError: a member is no array, or holds Python objects.
        zipfile.BadZipFile: the file is damaged.
    """
    with file.open("rb") if isinstance(file, Path) else nullcontext(file) as opened:
        with zipfile.ZipFile(opened) as archive:
            members = archive.infolist()
        return {member.filename.removesuffix(".npy"): _array(_content(opened, member)) for member in members}


def _content(file: BinaryIO, member: zipfile.ZipInfo) -> bytes:
    """Return the content of a member; of most, `ZipFile.read` takes several times as long.

    Raises:
        zipfile.BadZipFile: it is damaged.
    """
    file.seek(member.header_offset)
    *_, name, extra = _LOCAL.unpack(file.read(_LOCAL.size))
    names_agree = file.read(name) == member.orig_filename.encode()
    file.seek(extra, SEEK_CUR)
    content = file.read(member.compress_size)
    if member.compress_type == zipfile.ZIP_DEFLATED:
        content = zlib.decompressobj(-zlib.MAX_WBITS).decompress(content, member.file_size)
    if not names_agree or zlib.crc32(content) != member.CRC:
        raise zipfile.BadZipFile(f"{member.filename} is not what was written")
    return content


def _member(array: NDArray[Any]) -> bytes:
    """Return an array as an .npy file; `np.save` takes three times as long, mostly for equal headers."""
    return b"".join((_header_of(array.shape, array.dtype), np.ascontiguousarray(array).data))


@lru_cache(maxsize=256)
def _header_of(shape: tuple[int, ...], dtype: np.dtype[Any]) -> bytes:
    """Return what an .npy file of such an array begins with.

    Raises:
        ValueError: the array holds Python objects.
    """
    if dtype.hasobject:
        raise ValueError("arrays of Python objects cannot be saved")
    file = BytesIO()
    np.lib.format.write_array_header_1_0(
        file, {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    )
    return file.getvalue()


def _array(member: bytes) -> NDArray[Any]:
    """Return the array of an .npy file."""
    data = _FIRST + int.from_bytes(member[_FIRST - 2 : _FIRST], "little")
    if not member.startswith(_VERSION_1):
        return np.asarray(np.lib.format.read_array(BytesIO(member), allow_pickle=False))
    shape, is_fortran, dtype = _header(member[:data])
    if dtype.hasobject:
        raise ValueError("Object arrays cannot be loaded when allow_pickle=False")
    values = np.frombuffer(member, dtype, offset=data, count=math.prod(shape))
    return values.reshape(shape, order="F" if is_fortran else "C").copy()


@lru_cache(maxsize=256)
def _header(beginning: bytes) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Return shape, order and type of an array; the files of a study have a few different ones."""
    file = BytesIO(beginning)
    np.lib.format.read_magic(file)
    found: tuple[tuple[int, ...], bool, np.dtype[Any]] = np.lib.format.read_array_header_1_0(file)
    return found
