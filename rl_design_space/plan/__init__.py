"""Plans: design points with their identity, grids, studies and constraints.

This package is internal.
"""

__all__: list[str] = []
