"""Hydra plugins of rl-design-space. Hydra imports them at every start, so they import nothing heavy themselves."""
