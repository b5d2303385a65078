"""Iteration that can report its progress."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, TypeVar

Item = TypeVar("Item")


class Watch(Protocol):
    """Iterates over items, and shows how far it is."""

    def __call__(self, items: Sequence[Item], what: str, /) -> Iterable[Item]:
        """Return an iterable of the items; `what` is done with each of them."""
        ...


def unwatched(items: Sequence[Item], what: str) -> Iterable[Item]:
    """Return the items; nothing is shown."""
    return items
