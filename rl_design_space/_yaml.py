"""Values as they are typed in YAML and on the command line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def as_yaml(value: Any) -> str:
    """Return a value as it is typed, on one line; Hydra's override grammar reads it as well.

    Text is not quoted, so that sweeps such as `10,20` stay what they are.
    """
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(as_yaml, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key}: {as_yaml(inner)}' for key, inner in value.items())}}}"
    return str(value)
