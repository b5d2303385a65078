"""The available choices, options, studies and keys, read from the config files and the classes that they name.

All text comes from there: a description is the leading comment of a file or the docstring of its class, a range is the
annotation of a field, a default is the value in the file.

This package is internal: use `rl-design-space list` and `rl-design-space show`, with `--json` in programs.
"""

__all__: list[str] = []
