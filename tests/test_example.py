"""The example script runs as documented and prints the numbers of its points."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from rl_design_space.learning import simulate

EXAMPLE = Path(__file__).parents[1] / "docs" / "example.py"


def test_the_example_compares_and_draws(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    picture = tmp_path / "new" / "curves.png"
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), str(picture)])
    names = runpy.run_path(str(EXAMPLE), run_name="__main__")
    header, *rows, paired, last = capsys.readouterr().out.splitlines()
    assert last == str(picture)

    curves = {name: simulate(point, threads=1) for name, point in names["POINTS"].items()}
    np.testing.assert_array_equal(curves["ad hoc"].optimum, curves["direction"].optimum)
    totals = {name: learned.total_steps for name, learned in curves.items()}
    assert header.split()[:2] == ["total", "steps"]
    assert [row.startswith(f"{name} ") for row, name in zip(rows, totals, strict=True)] == [True, True]
    assert all(f" {total.mean():,.0f} " in row for row, total in zip(rows, totals.values(), strict=True))
    differences = totals["direction"] - totals["ad hoc"]
    assert paired.startswith(f"direction minus ad hoc, in pairs: {differences.mean():+,.0f} steps a period (95 % ")
    assert paired.endswith(f"fewer in {(differences < 0).mean():.0%} of the periods")

    pixels = imread(picture)
    assert pixels.shape == (600, 1050, 4)
    assert pixels.std() > 0.01


def test_the_picture_is_written_to_outputs_by_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE)])
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    assert [path.name for path in (tmp_path / "outputs").iterdir()] == ["example.png"]
