"""Sweeping: from overrides and studies to planned points, and from planned points to tracked runs."""
