"""Hydra: from config files and overrides to validated components, and its errors as messages."""
