"""Whose a message is: names of a robot's topics, joints and frames beside those of other robots."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.errors import OutOfLimits
from holonom.signals import Kind, Topic

__all__ = ["COMMON", "Scope", "bare"]

COMMON = ("world", "map")
"""Frames that belong to no robot."""


@dataclass(frozen=True, slots=True)
class Scope:
    """A robot: its name, "" where it is alone, its joints or wheels, and which of its frames is the tool.

    Raises
    ------
    OutOfLimits
        A name that topics could not be told apart by.
    """

    robot: str
    joints: tuple[str, ...]
    tool: str = "tool"

    def __post_init__(self) -> None:
        if self.robot in (*Kind, "signals") or set(self.robot) & set("/."):
            raise OutOfLimits(
                f"a robot is called {self.robot!r}; a name without / and . is allowed, but not "
                f"{', '.join((*Kind, 'signals'))}"
            )

    def topic(self, topic: Topic, name: str) -> str:
        """Topic of this robot for a row of the table."""
        return name if topic.shared or not self.robot else f"/{self.robot}{name}"

    def frame(self, name: str) -> str:
        """Frame of this robot."""
        return name if name in COMMON or not self.robot else f"{self.robot}/{name}"

    def dotted(self, name: str) -> str:
        """Joint of this robot, or source of an event."""
        return f"{self.robot}.{name}" if self.robot else name


def bare(name: str, robot: str, mark: str) -> str:
    """Name without its robot, which a mark ("/" or ".") closes."""
    return name.removeprefix(robot + mark) if robot else name
