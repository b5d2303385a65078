"""Configuration with Hydra: compose config files and overrides, build validated components, explain errors.

This package is internal.
"""

__all__: list[str] = []
