"""Pictures of the inside of a period: what the agent knows, where it was, and which way it took."""

from rl_design_space.report.inside.watched import watch

__all__ = ["watch"]
