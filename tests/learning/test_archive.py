"""The file format of results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rl_design_space.learning.archive import read_arrays


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
