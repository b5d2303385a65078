"""The command lines `rl-design-space` and `rl-design-report`, and what they print.

This package is internal.
"""

__all__: list[str] = []
