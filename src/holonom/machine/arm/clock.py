"""Sample times of an arm's controller."""

from holonom.errors import OutOfLimits

__all__ = ["PROGRAM_TICK", "TICK", "samples_per_tick"]

TICK = 1e-3
"""Sample time of a reference unless the servos have another, s."""
PROGRAM_TICK = 0.01
"""Interval of the program and of the recording, s."""


def samples_per_tick(servo: float) -> int:
    """Return how many periods of the servos, s, a program's tick has.

    Raises
    ------
    OutOfLimits
        It has no whole number of them.
    """
    count = round(PROGRAM_TICK / servo)
    if count < 1 or abs(count * servo - PROGRAM_TICK) > 1e-9:
        raise OutOfLimits(
            f"the servos' period is {1e3 * servo:g} ms; a program's tick is {1e3 * PROGRAM_TICK:g} ms: give a period "
            "of which it is a multiple, 0.5, 1, 2, 2.5, 5 or 10 ms"
        )
    return count
