"""Executors on clusters: Dask and Ray.

This package is internal.
"""

__all__: list[str] = []
