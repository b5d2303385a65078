"""Resolvers for interpolations in the shipped configuration."""

from __future__ import annotations

from omegaconf import OmegaConf

from rl_design_space._paths import expanded


def register_resolvers() -> None:
    """Register `${expanded:PATH}`, which is for the folders that Hydra creates before a job starts."""
    OmegaConf.register_new_resolver("expanded", expanded, replace=True)
