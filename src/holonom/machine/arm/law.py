"""`JointLaw`: a controller of an arm's joints that is not compiled: what a method of the table may make."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from holonom.arrays import Array
from holonom.mechanics import Arm

__all__ = ["JointLaw"]


@runtime_checkable
class JointLaw(Protocol):
    """Joint torques from a reference and what is measured, once each period of the model level."""

    def torques(self, arm: Arm, reference: Array, position: Array, speed: Array, dt: float) -> Array:
        """Return joint torques (n,), N m or N.

        Parameters
        ----------
        arm
            The model that the controller knows.
        reference
            (3, n): position, speed, acceleration.
        position, speed
            Measured, (n,).
        dt
            Time since the last call, s.
        """
