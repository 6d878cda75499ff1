"""Homing: from a counter that knows no zero to a position, by state machines with every way they can fail."""

__all__: list[str] = []
