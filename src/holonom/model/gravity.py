"""Standard gravity, stated once."""

__all__ = ["GRAVITY"]

GRAVITY = 9.81
"""m/s2, as the textbooks and Pinocchio have it."""
