"""Learning: tables in, learning curves out."""

from typing import TYPE_CHECKING, Any

from rl_design_space.learning.result import LearningCurves

if TYPE_CHECKING:
    from rl_design_space.learning.simulation import simulate

__all__ = ["LearningCurves", "simulate"]


def __getattr__(name: str) -> Any:
    """Import the compiled kernel only when it is needed: Numba takes half a second."""
    if name == "simulate":
        from rl_design_space.learning.simulation import simulate

        return simulate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
