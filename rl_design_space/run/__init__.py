"""Run planned points: skip recorded points, learn the others, record each once.

This package is internal.
"""

__all__: list[str] = []
