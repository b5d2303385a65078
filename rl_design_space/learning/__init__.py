"""Learning: from the tables of a design point to its learning curves."""

from typing import TYPE_CHECKING, Any

from rl_design_space.learning.result import LearningCurves

if TYPE_CHECKING:
    from rl_design_space.learning.simulation import simulate

__all__ = ["LearningCurves", "simulate"]


def __getattr__(name: str) -> Any:
    """Import `simulate` on first use: importing Numba takes half a second."""
    if name == "simulate":
        from rl_design_space.learning.simulation import simulate

        return simulate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
