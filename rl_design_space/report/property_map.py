"""Table 1 as a heatmap: properties of representations; what can be measured is, the rest is marked as the paper's."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.config.build import construct
from rl_design_space.design import Representation, SizedRepresentation, Torus, cell_count
from rl_design_space.errors import ConfigError
from rl_design_space.report.grades import Cell, Grading, cells_frame

if TYPE_CHECKING:
    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader

_MEASURED = ("situation information", "perceptual aliasing", "size of state space", "generalisation")


@dataclass(frozen=True, kw_only=True, config=STRICT)
class PropertyMap:
    """Properties of representations on random layouts, without any learning.

    Attributes:
        title: of the report.
        representations: by name, each an option.
        size: side of the torus.
        larger: side of the one that a Q-matrix is to be carried to.
        goals: of a layout.
        layouts: how many are looked at.
        gradings: of the columns that are measured.
        paper: the paper's grades by representation and column; columns that are only here are the paper's judgement.
        labels: how names read.
    """

    title: Annotated[str, Field(min_length=1)]
    representations: dict[str, Any]
    size: Annotated[int, Field(ge=2)]
    larger: Annotated[int, Field(ge=2)]
    goals: Annotated[int, Field(ge=1)]
    layouts: Annotated[int, Field(ge=2)]
    gradings: dict[str, dict[str, Any]]
    paper: dict[str, dict[str, str]]
    labels: dict[str, str]

    def built_gradings(self) -> dict[str, Grading]:
        """The gradings, validated."""
        return {name: construct(Grading, self.gradings[name], f"study.report.gradings.{name}") for name in _MEASURED}

    def cells(self) -> list[Cell]:
        """The cells of the table, graded.

        Raises:
            ConfigError: a representation has no size, or its option is not as it should be.
        """
        numbers = {name: self._numbers(name, each) for name, each in self.representations.items()}
        gradings = self.built_gradings()
        cells = []
        for column in next(iter(self.paper.values())):
            least = min((each[column][0] for each in numbers.values() if column in each), default=math.nan)
            for row, each in numbers.items():
                number, text = each.get(column, (math.nan, "judged by the paper"))
                grade = gradings[column].grade(number, least) if column in each else ""
                cells.append(Cell(row, column, number, text, grade, self.paper[row][column]))
        return cells

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.grades_picture import draw, table_lines
        from rl_design_space.report.heatmap import save
        from rl_design_space.report.markdown import made_by

        cells = self.cells()
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        paths = save(draw(cells, self.title, self.labels), stem)
        cells_frame(cells).to_csv(stem.with_suffix(".csv"), index=False)
        lines = [
            f"# {self.title}",
            "",
            f"![Our grades for each property of each representation, and the paper's]({study.name}.png)",
            "",
            made_by(study),
            "",
            *table_lines(cells, self.built_gradings(), self.labels),
            f"Exact on {self.layouts} random layouts of {self.goals} goals on a {self.size}×{self.size} torus; the "
            f"larger grid is {self.larger}×{self.larger}. A state is a cell and a success counter; whether a move is "
            "optimal is found by breadth-first search. ++ under perceptual aliasing means: much of it. "
            "Implementability is the paper's judgement.",
            "",
        ]
        stem.with_suffix(".md").write_text("\n".join(lines), encoding="utf-8")
        return [*paths, stem.with_suffix(".csv"), stem.with_suffix(".md")]

    def _numbers(self, name: str, representation: Any) -> dict[str, tuple[float, str]]:
        """What each measured cell is graded by, and what it says."""
        from rl_design_space.analysis.properties import properties
        from rl_design_space.learning.streams import layouts

        if not isinstance(representation, Representation) or not isinstance(representation, SizedRepresentation):
            raise ConfigError(f"study.report.representations.{name}: should be a representation with a size")
        world, larger = Torus(size=self.size), Torus(size=self.larger)
        here, there = (layouts(0, cell_count(each), self.goals, self.layouts) for each in (world, larger))
        found = properties(representation, world, larger, here, there)
        size = representation.spanned_size(world, self.goals)
        return {
            "situation information": (found.states_each, f"a state is seen as\n{found.states_each:.1f} states"),
            "perceptual aliasing": (found.aliased, f"{found.aliased:.0%} of states have\nno agreed move"),
            "size of state space": (float(size), f"{size:,} observations"),
            "generalisation": (
                (found.other_goals + found.larger_grid) / 2,
                f"{found.other_goals:.0%} right with other goals,\n{found.larger_grid:.0%} on a larger grid",
            ),
        }
