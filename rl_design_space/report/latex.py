"""LaTeX: tables for the package booktabs."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from rl_design_space.report.markdown import MARKED, alignment

#: What means more than itself in LaTeX, and signs that its usual fonts do not have. A bracket after the end of a row
#: would be an argument of it.
_SIGNS = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_", "{": r"\{", "}": r"\}",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": r"\textless{}", ">": r"\textgreater{}",
    "|": r"\textbar{}", '"': "''", "[": "{[}", "]": "{]}", "≥": r"$\geq$", "≤": r"$\leq$", "×": r"$\times$",
    "−": "$-$", "–": "--", "—": "---", "…": r"\dots{}", "†": r"\textdagger{}", "★": r"$\star$", "ε": r"$\varepsilon$",
    "Σ": r"$\Sigma$", "σ": r"$\sigma$", "τ": r"$\tau$", "γ": r"$\gamma$", "α": r"$\alpha$", "λ": r"$\lambda$",
    "→": r"$\rightarrow$", "∞": r"$\infty$", "✓": r"$\surd$", "✗": r"$\times$", "\xa0": "~",
}  # fmt: skip
_TABLE = str.maketrans(_SIGNS)


def latex_table(frame: pd.DataFrame, made_by: Sequence[str] = ()) -> str:
    """Return a frame of texts as a tabular; columns of numbers are aligned on the right, the index is left out.

    Args:
        frame: cells may have code and bold text in Markdown.
        made_by: lines of a comment above it.
    """
    texts = frame.map(lambda cell: " ".join(str(cell).split()))
    columns = "".join(alignment(list(column))[0] for _, column in texts.items())
    rows = [_row(row) for row in texts.itertuples(index=False)]
    return "\n".join(
        [
            *(f"% {' '.join(line.split())}" for line in made_by),
            rf"\begin{{tabular}}{{{columns}}}",
            r"\toprule",
            _row([" ".join(str(name).split()) for name in texts.columns]),
            r"\midrule",
            *rows,
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def _row(cells: Sequence[str]) -> str:
    return f"{' & '.join(map(_cell, cells))} \\\\"


def _cell(text: str) -> str:
    parts, begin = [], 0
    for match in MARKED.finditer(text):
        parts.append(text[begin : match.start()].translate(_TABLE))
        command, inner = (r"\texttt", match[2].strip()) if match[2] else (r"\textbf", match[3])
        parts.append(f"{command}{{{inner.translate(_TABLE)}}}")
        begin = match.end()
    return "".join([*parts, text[begin:].translate(_TABLE)])
