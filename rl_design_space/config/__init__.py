"""Configuration with Hydra: compose config files and overrides, build validated components, explain errors."""
