"""Hydra plugins of rl-design-space. Hydra imports them at every start, so their modules import nothing heavy."""
