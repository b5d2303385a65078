"""Reports: tables and figures of tracked runs. Nothing here starts to learn."""

from rl_design_space.report.published_table import PublishedTable

__all__ = ["PublishedTable"]
