"""What reports say about designs that are no full factorial."""

from __future__ import annotations

from rl_design_space.analysis.factorial import Grids


def gap_remarks(grids: Grids) -> list[str]:
    """Return what the factorials are, and which choices nothing can be said about; empty if there is a whole one."""
    if grids.is_whole:
        return []
    shapes = [
        " × ".join(f"{size} {factor.name}" for size, factor in zip(part.points.shape, part.factors, strict=True))
        for part in grids.parts
    ]
    more = f", and {len(shapes) - 4} more" if len(shapes) > 4 else ""
    alone = f" {grids.alone:,} designs belong to none, and are left out." if grids.alone else ""
    remarks = [
        f"Not all combinations are there. {grids.gap}. The designs are taken as {len(shapes)} factorials "
        f"({'; '.join(shapes[:4])}{more}), weighted by their numbers of designs: the variance within factorials is "
        f"what is explained, and a choice with one value in a factorial explains nothing there.{alone}"
    ]
    remarks += [
        f"{name}: nothing can be said, because no two designs differ in it and belong to one factorial; empty are "
        f"{'; '.join(grids.empty)}."
        for name in grids.unknown
    ]
    return remarks
