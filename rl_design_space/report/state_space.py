"""Table 2: the size of the state space by the published formula, as it is met, and as it is learned."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from pydantic import Field
from pydantic.dataclasses import dataclass

from rl_design_space._strict import STRICT
from rl_design_space.report.study_runs import Runs

if TYPE_CHECKING:
    import pandas as pd

    from rl_design_space.plan.study import Study
    from rl_design_space.tracking.read import Reader


@dataclass(frozen=True, kw_only=True, config=STRICT)
class StateSpace:
    """Rows of a Q-matrix for each representation, size and number of goals.

    Attributes:
        title: of the report.
        published: the paper's number by representation, size and number of goals.
        labels: how names read.
    """

    title: Annotated[str, Field(min_length=1)]
    published: dict[str, dict[int, dict[int, int]]]
    labels: dict[str, str]

    def frame(self, runs: Runs) -> pd.DataFrame:
        """One row a point of the study.

        Returns:
            representation, size, goals; paper; formula, by the package; spanned, all observations that there can be;
            met, rows that a period can meet, and learned, those that anything was learned for: means over periods with
            95 % intervals, NaN where the point was not recorded.
        """
        import pandas as pd

        from rl_design_space.analysis.statistics import mean_estimate

        rows = []
        for planned in runs.plan:
            point, recorded = planned.point, runs.periods(planned)
            name, size, goals = planned.options["representation"], point.world.shape[0], point.task.goals
            kinds = ("published_size", "spanned_size")
            sizes = [getattr(point.representation, kind)(point.world, goals) for kind in kinds]
            measured = (float("nan"),) * 6
            if recorded:
                met, learned = (mean_estimate(recorded.rows[:, i].astype(float)) for i in (0, 1))
                measured = (*met, *learned)
            rows.append((name, size, goals, self.published[name][size][goals], *sizes, *measured))
        columns = ["representation", "size", "goals", "paper", "formula", "spanned", "met", "met_low", "met_high"]
        return pd.DataFrame(rows, columns=[*columns, "learned", "learned_low", "learned_high"])

    def write(self, study: Study, reader: Reader, folder: Path) -> list[Path]:
        """Write NAME.png, .svg, .csv and .md into a folder; the paths written."""
        from rl_design_space.report.heatmap import save
        from rl_design_space.report.state_space_page import draw, state_space_text

        runs = Runs(study.plan, reader)
        sizes = self.frame(runs)
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / study.name
        paths = save(draw(sizes, self.title, self.labels), stem, study.mark)
        sizes.to_csv(stem.with_suffix(".csv"), index=False)
        text = state_space_text(study, sizes, self.title, self.labels, len(runs.missing))
        stem.with_suffix(".md").write_text(text, encoding="utf-8")
        return [*paths, stem.with_suffix(".csv"), stem.with_suffix(".md")]
