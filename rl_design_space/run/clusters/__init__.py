"""Executors on clusters: Dask and Ray."""
