"""Sample times of an arm's controller."""

__all__ = ["PROGRAM_TICK", "TICK"]

TICK = 1e-3
"""Sample time of the position loop and of a reference, s."""
PROGRAM_TICK = 0.01
"""Interval of the program and of the recording, s."""
