"""Tracking: learning curves into MLflow, and runs back out of it."""

from rl_design_space.tracking.backends import MlflowTracking, NoTracking, Tracking

__all__ = ["MlflowTracking", "NoTracking", "Tracking"]
