"""Absolute encoders: Gray code, turns, and the frames in which they send a position (specification 03.3)."""

__all__: list[str] = []
