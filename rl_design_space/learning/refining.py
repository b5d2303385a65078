"""Splitting the blocks of a stage for the next one (docs/decisions/0035-refined-blocks.md)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rl_design_space.design import Refinement
from rl_design_space.learning.compiled import compiled, compiled_and_kept
from rl_design_space.learning.td_errors import Errors

#: Which blocks are split, see `Refinement`.
_SPLITS = ("none", "all", "disagreeing")
_NONE, _DISAGREEING = 0, 2


def refine_into(
    codes: NDArray[np.int64], rows: NDArray[np.int64], width: int, refinement: Refinement, errors: Errors
) -> None:
    """Split the blocks of a stage in several periods.

    Args:
        codes: (periods, n_goals, cells), output: observation codes, the number of the first state of each block.
        rows: (periods, n_goals, cells) row of each state before; or of one period, if all have the same. The states of
            a row are a rectangle at one counter.
        width: cells of the world along x.
        refinement: which blocks are split.
        errors: TD errors of the stage before; of no period unless blocks are split that disagree.
    """
    most = codes[:1].size if refinement.rows is None else refinement.rows
    _refine(rows, width, _SPLITS.index(refinement.split), most, errors.sums, errors.counts, codes)


@compiled
def _disagreement(row_of, n_rows, sums, counts):
    """Return how much the cells of each row disagree, (n_rows,): the sum of squares between cells of their TD errors.

    With δ(c, a) the mean error of action a in cell c, n(c, a) how often it was executed there, and δ(a) its mean error
    in the whole row, it is the sum over cells and actions of n(c, a) · (δ(c, a) − δ(a))².

    Args:
        row_of: (states,) row of each state.
        n_rows: number of rows.
        sums: see `Errors`, of one period.
        counts: see `Errors`, of one period.
    """
    n_actions = sums.shape[1]
    row_sums, row_counts = np.zeros((n_rows, n_actions)), np.zeros((n_rows, n_actions), dtype=np.int64)
    for state in range(len(row_of)):
        for action in range(n_actions):
            row_sums[row_of[state], action] += sums[state, action]
            row_counts[row_of[state], action] += counts[state, action]
    found = np.zeros(n_rows)
    for state in range(len(row_of)):
        row = row_of[state]
        for action in range(n_actions):
            count = counts[state, action]
            if count > 0:
                apart = sums[state, action] / count - row_sums[row, action] / row_counts[row, action]
                found[row] += count * (apart * apart)
    return found


@compiled_and_kept
def _refine(rows, width, split, most, sums, counts, codes):
    """Split blocks, see `refine_into`; `most` is the most rows afterwards."""
    cells = rows.shape[2]
    for period in range(len(codes)):
        row_of = rows[period % len(rows)].ravel()
        n_rows = row_of.max() + 1
        # First and last column and line of each block.
        left, right = np.full(n_rows, width), np.full(n_rows, -1)
        above, below = np.full(n_rows, cells), np.full(n_rows, -1)
        for state in range(len(row_of)):
            row, x, y = row_of[state], state % cells % width, state % cells // width
            left[row], right[row] = min(left[row], x), max(right[row], x)
            above[row], below[row] = min(above[row], y), max(below[row], y)

        order = np.arange(n_rows)
        found = np.ones(n_rows)
        if split == _DISAGREEING:
            found = _disagreement(row_of, n_rows, sums[period], counts[period])
            # Stable: of equal ones, the first row comes first.
            order = np.argsort(-found, kind="mergesort")
        is_split = np.zeros(n_rows, dtype=np.bool_)
        total = n_rows
        for row in order:
            parts = (2 if right[row] > left[row] else 1) * (2 if below[row] > above[row] else 1)
            if split != _NONE and found[row] > 0 and parts > 1 and total + parts - 1 <= most:
                is_split[row] = True
                total += parts - 1

        for state in range(len(row_of)):
            row, x, y = row_of[state], state % cells % width, state % cells // width
            first_x, first_y = left[row], above[row]
            if is_split[row]:
                middle_x, middle_y = (left[row] + right[row]) // 2 + 1, (above[row] + below[row]) // 2 + 1
                first_x = middle_x if x >= middle_x else first_x
                first_y = middle_y if y >= middle_y else first_y
            codes[period, state // cells, state % cells] = state // cells * cells + first_y * width + first_x
