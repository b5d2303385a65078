"""Tracking: recording learning curves in MLflow, and reading runs back.

How a result gets into the store:

    command                                              tracker process
    MlflowTracker.record ──Record──> Spool (on disk) ──> Delivery ──> StoreWriter ──> MLflow
    BackgroundDelivery ──TrackerProcess──────────────────^ process.main

`BackgroundDelivery` keeps the process running and notices which records have left the spool; `Delivery` decides what to
retry and what to quarantine; a `StoreWriter` writes records, and may be interrupted anywhere: `DatabaseWriter` several
in one transaction, `ClientWriter` step by step with MLflow's client, into a server several points at a time.
`rl-design-space sync` runs a `Delivery` in its own process.
"""

from rl_design_space.tracking.backends import MlflowTracking, NoTracking, Tracking

__all__ = ["MlflowTracking", "NoTracking", "Tracking"]
