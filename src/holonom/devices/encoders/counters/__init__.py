"""Counters that wrap, and the index that says what they lost (specification 03.3)."""

__all__: list[str] = []
