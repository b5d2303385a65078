"""The file format of results."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from rl_design_space.learning.archive import read_arrays, write_arrays


class _Runs:
    """An object whose pickle runs code when it is read."""

    def __init__(self, file: Path) -> None:
        self._file = file

    def __reduce__(self) -> tuple[object, ...]:
        return Path.touch, (self._file,)


def test_a_pickle_in_a_file_is_refused_and_not_run(tmp_path: Path):
    np.savez(tmp_path / "periods.npz", steps=np.array([_Runs(tmp_path / "run")], dtype=object))
    with pytest.raises(ValueError, match="allow_pickle"):
        read_arrays(tmp_path / "periods.npz")
    assert not (tmp_path / "run").exists()


def test_objects_are_not_written(tmp_path: Path):
    with pytest.raises(ValueError, match="Python objects"):
        write_arrays(tmp_path / "periods.npz", {"steps": np.array([None])})


def test_members_are_those_that_numpy_writes(tmp_path: Path):
    arrays = {
        "rows": np.arange(6, dtype=np.uint16).reshape(2, 3),
        "column": np.arange(6.0).reshape(2, 3)[:, 1],
        "empty": np.empty((0, 4), dtype=bool),
        "number": np.array(3.5),
    }
    write_arrays(tmp_path / "arrays.npz", arrays)
    with zipfile.ZipFile(tmp_path / "arrays.npz") as archive:
        for name, array in arrays.items():
            np.save(tmp_path / "array.npy", array)
            assert archive.read(f"{name}.npy") == (tmp_path / "array.npy").read_bytes()


def test_arrays_are_those_that_numpy_reads(tmp_path: Path):
    arrays = {
        "plain": np.arange(6, dtype=np.uint16).reshape(2, 3),
        "columns first": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "empty": np.empty((0, 4), dtype=bool),
        "number": np.array(3.5),
        "second version": np.arange(3),
    }
    np.savez_compressed(tmp_path / "arrays.npz", **{name: arrays[name] for name in list(arrays)[:-1]})
    with zipfile.ZipFile(tmp_path / "arrays.npz", "a") as archive, archive.open("second version.npy", "w") as member:
        np.lib.format.write_array(member, arrays["second version"], version=(2, 0))
    found = read_arrays(tmp_path / "arrays.npz")
    assert found.keys() == arrays.keys()
    for name, array in arrays.items():
        assert (found[name].dtype, found[name].flags.writeable) == (array.dtype, True)
        np.testing.assert_array_equal(found[name], array)
