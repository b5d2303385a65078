"""Tracking: recording learning curves in MLflow, and reading runs back."""

from rl_design_space.tracking.backends import MlflowTracking, NoTracking, Tracking

__all__ = ["MlflowTracking", "NoTracking", "Tracking"]
