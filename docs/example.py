"""Compare two representations on the same starts and goals: `python docs/example.py [PICTURE]`.

Learns two design points that differ only in their representation, prints a table and the paired difference of their
total steps, and saves their learning curves as a picture (outputs/example.png).
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import pandas as pd

mpl.use("Agg")

import matplotlib.pyplot as plt

import rl_design_space as rds
from rl_design_space.analysis.statistics import mean_estimate

BASE = rds.DesignPoint(exploration=rds.Linear(k=0.03))
POINTS = {
    "ad hoc": replace(BASE, representation=rds.AdHoc()),
    "direction": replace(BASE, representation=rds.Direction()),
}


def table(curves: dict[str, rds.LearningCurves]) -> pd.DataFrame:
    """Return one row a representation: steps a period with their 95 % interval, failed trials, final quality."""
    rows = {}
    for name, learned in curves.items():
        total = mean_estimate(learned.total_steps)
        scalars = learned.scalars()
        rows[name] = {
            "total steps": f"{total.value:,.0f}",
            "95 % interval": f"{total.low:,.0f} to {total.high:,.0f}",
            "failed trials": f"{scalars['failed_trials']:.2%}",
            "final / optimum": f"{scalars['final_steps_over_optimum']:.2f}",
        }
    return pd.DataFrame(rows).T


def difference(curves: dict[str, rds.LearningCurves]) -> str:
    """Describe how many more steps the second one needs; layouts are the same, so periods are compared in pairs."""
    first, second = curves
    paired = curves[second].total_steps - curves[first].total_steps
    more = mean_estimate(paired)
    return (
        f"{second} minus {first}, in pairs: {more.value:+,.0f} steps a period "
        f"(95 % interval {more.low:+,.0f} to {more.high:+,.0f}); fewer in {(paired < 0).mean():.0%} of the periods"
    )


def draw(curves: dict[str, rds.LearningCurves], picture: Path) -> None:
    """Draw the mean steps of every trial, and the middle 80 % of periods."""
    figure, axis = plt.subplots(figsize=(7, 4), layout="constrained")
    for name, learned in curves.items():
        frame = learned.to_frame()
        (line,) = axis.plot(frame["trial"], frame["steps/mean"], label=name)
        axis.fill_between(frame["trial"], frame["steps/q10"], frame["steps/q90"], color=line.get_color(), alpha=0.15)
    optimum = next(iter(curves.values())).optimum.mean()
    axis.axhline(optimum, color="black", linestyle=":", label="optimum")
    axis.set(xlabel="trial", ylabel="steps to the final goal (band: 10 to 90 %)", yscale="log")
    axis.legend()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=150)
    plt.close(figure)


def main() -> None:
    """Learn the points, print the comparison and draw the curves."""
    picture = Path(sys.argv[1] if len(sys.argv) > 1 else "outputs/example.png")
    curves = {name: rds.simulate(point) for name, point in POINTS.items()}
    print(table(curves).to_string())
    print(difference(curves))
    draw(curves, picture)
    print(picture)


if __name__ == "__main__":
    main()
