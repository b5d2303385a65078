"""The picture of scaling: cost against the size of the world and against the number of periods."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")  # before pyplot is imported: there need not be a screen

import matplotlib.pyplot as plt
import pandas as pd
import seaborn as sns
from matplotlib.ticker import FixedLocator, LogLocator, NullLocator, ScalarFormatter

from benchmarks.scaling import PERIODS, WORLD

_TITLES = {WORLD: "Cost against world size", PERIODS: "Cost against number of periods, 10×10"}
_LABELS = {WORLD: "cells a side, d", PERIODS: "periods of a call"}


def plot(calls: pd.DataFrame, target: Path) -> None:
    """Draw medians over the rounds, with a band from the first to the third quartile."""
    sns.set_theme(context="paper", style="whitegrid", palette="colorblind")
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for axis, panel in zip(axes, (WORLD, PERIODS), strict=True):
        data = calls[calls["panel"] == panel].astype({"x": int})
        sns.lineplot(
            data, x="x", y="ns", hue="line", style="line", markers=True, dashes=False,
            estimator="median", errorbar=("pi", 50), ax=axis,
        )  # fmt: skip
        axis.set(title=_TITLES[panel], xlabel=_LABELS[panel], ylabel="ns a step", xscale="log")
        axis.xaxis.set_major_locator(FixedLocator(sorted(data["x"].unique())))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.xaxis.set_major_formatter(ScalarFormatter())
        axis.legend(title=None)
    # One call of few periods is nearly all overhead: only a logarithm shows both ends.
    axes[0].set_ylim(bottom=0)
    axes[1].set_yscale("log")
    axes[1].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[1].yaxis.set_minor_locator(NullLocator())
    axes[1].yaxis.set_major_formatter(ScalarFormatter())
    figure.savefig(target, dpi=150)
    plt.close(figure)
