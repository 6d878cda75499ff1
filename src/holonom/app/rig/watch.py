"""`Watch`: what an arm presses on and which of its drives are at their limit, told once for each spell."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from holonom.closed_loop import SimulatedArm
from holonom.errors import ContactFault

__all__ = ["Watch"]

NOTED = 5.0
"""Force, N, from which a contact is told."""
SPELL = 10
"""Ticks that a current must be at its limit to be told, and away from it to be told again."""


class Watch:
    """Looks at an arm after each tick. Mutable state: what it has told.

    Parameters
    ----------
    arm
        Whose contacts and drives are watched.
    most
        Force, N, above which the cell stops it.
    tell
        Takes source and text of an event.
    """

    def __init__(self, arm: SimulatedArm, most: float, tell: Callable[[str, str], None]) -> None:
        self._arm, self._most, self._tell = arm, most, tell
        self._touching = False
        self._spells = np.zeros(arm.loop.arm.n, dtype=int)
        self._told = np.zeros(arm.loop.arm.n, dtype=bool)

    def look(self) -> None:
        """Tell what is new.

        Raises
        ------
        ContactFault
            A force above what the cell allows, or joints without forces inside a surface.
        """
        self._currents()
        contact = self._arm.contact()
        touches = contact is not None and (contact.force is None or contact.force >= NOTED)
        if contact is not None and touches and not self._touching:
            x, y, z = 1e3 * self._arm.tool_pose()[:3, 3]
            force = "" if contact.force is None else f" with {contact.force:.0f} N"
            self._tell("contact", f"touches {contact.surface}{force} at ({x:.0f}, {y:.0f}, {z:.0f}) mm")
        self._touching = touches
        if contact is None:
            return
        if contact.beside:
            raise ContactFault(
                f"the tool runs into the side of {contact.surface}, {1e3 * contact.depth:.0f} mm below its top; "
                "go around it, or above it"
            )
        if contact.force is None:
            raise ContactFault(
                f"the tool is {1e3 * contact.depth:.0f} mm inside {contact.surface}, which ideal joints do not feel; "
                "ask for a place above it"
            )
        if contact.force > self._most:
            raise ContactFault(
                f"the tool presses on {contact.surface} with {contact.force:.0f} N; the cell allows {self._most:g} N "
                "(limits.contact_force): ask for a place above it, or allow more"
            )

    def _currents(self) -> None:
        """Each joint whose drive has been at a limit for a while, once for each such spell."""
        said = self._arm.loop.at_limit()
        at = np.array([bool(text) for text in said])
        self._spells = np.where(at, np.maximum(self._spells, 0) + 1, np.minimum(self._spells, 0) - 1)
        for joint in np.flatnonzero((self._spells >= SPELL) & ~self._told):
            self._tell("drive", f"{self._arm.loop.arm.limits.names[joint]}: {said[joint]}")
        self._told = (self._told | (self._spells >= SPELL)) & ~(self._spells <= -SPELL)
