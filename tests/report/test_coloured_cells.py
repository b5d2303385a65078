"""Coloured cells are those of seaborn's heatmap, pixel by pixel."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
import seaborn as sns
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm

from rl_design_space.report.coloured_cells import draw_cells
from rl_design_space.report.style import colours, styled

#: Few names; so many rows that not all have names; names of columns that are longer than the cells are wide.
TABLES = {
    "few": pd.DataFrame([[1, np.nan, 3.0]], index=["a"], columns=pd.Index([0.1, 0.2, 0.3], name="k")),
    "many": pd.DataFrame(np.arange(1.0, 81.0).reshape(40, 2)),
    "long": pd.DataFrame(np.ones((2, 6)), columns=[f"a name of column {number}" for number in range(6)]),
}


@pytest.mark.parametrize("name", TABLES)
@styled()
def test_cells_are_those_of_seaborn(name: str):
    values, pictures = TABLES[name], []
    for is_ours in (True, False):
        figure, axis = plt.subplots(figsize=(3, 2.5), layout="constrained")
        norm = LogNorm(1, 80)
        if is_ours:
            draw_cells(axis, values, norm, "cividis_r", line_width=1.5)
        else:
            sns.heatmap(values, ax=axis, norm=norm, cmap="cividis_r", cbar=False, linewidths=1.5)
            axis.set_yticklabels(axis.get_yticklabels(), rotation=0)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        pictures.append(np.asarray(canvas.buffer_rgba()))
        plt.close(figure)
    assert np.array_equal(*pictures)


def test_colours_are_those_of_seaborn():
    assert list(colours(12)) == list(sns.color_palette("colorblind", 12))
