"""The multiverse of a claim: its outcome under every sensible way to read, measure and judge it."""

__all__: list[str] = []
