"""Encoders: from an angle to counts, and back to angle and speed (specification 03.3)."""

__all__: list[str] = []
