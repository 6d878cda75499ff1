"""The kinds of joints: one table, from which units, whole turns, and what a kind is made of follow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from holonom.registry import Method, Table

__all__ = ["JOINT_KINDS", "JointKind", "kind_of"]


@dataclass(frozen=True, slots=True)
class JointKind:
    """What a kind of joint does.

    Attributes
    ----------
    made_of
        Joints of one freedom in a row that move as it does: (what follows its name, kind, axis in its own frame,
        whose z is the joint's). Equations of motion are written for those that are made of themselves alone.
    turns
        Whether its position is an angle, of which whole turns change nothing.
    unit, effort
        Units of its position and of its force.
    free
        Whether it moves every way at once: it has no place in q, the base's pose and twist are inputs of their own.
    """

    made_of: tuple[tuple[str, str, str], ...]
    turns: bool = False
    unit: str = ""
    effort: str = ""
    free: bool = False

    @property
    def single(self) -> bool:
        """Whether it has one freedom."""
        return len(self.made_of) == 1

    @property
    def speed(self) -> str:
        """Unit of its speed."""
        return f"{self.unit}/s"


_TURN = JointKind((("", "revolute", "z"),), turns=True, unit="rad", effort="N m")
_SLIDE = JointKind((("", "prismatic", "z"),), unit="m", effort="N")
_PLANE = JointKind(((".x", "prismatic", "x"), (".y", "prismatic", "y"), (".turn", "revolute", "z")))
_CRAIG = "Craig, Introduction to Robotics, 3.2"
_SICILIANO = "Siciliano et al., Robotics: Modelling, Planning and Control, 1.2"
_FEATHERSTONE = "Featherstone, Rigid Body Dynamics Algorithms, 4.4"

JOINT_KINDS = Table(
    "joint_kinds",
    "joint kind",
    "its freedoms",
    {
        "fixed": Method("holds its link to the one before", lambda _: JointKind(()), _CRAIG),
        "revolute": Method("turns about its z axis, rad", lambda _: _TURN, _CRAIG),
        "prismatic": Method("slides along its z axis, m", lambda _: _SLIDE, _CRAIG),
        "planar": Method("slides along its x and y axes and turns about z: three joints", lambda _: _PLANE, _SICILIANO),
        "floating": Method(
            "lets the base move every way: its pose and twist are inputs beside q",
            lambda _: JointKind((), free=True),
            _FEATHERSTONE,
        ),
    },
    closed=True,
)
"""The equations of motion are written for these, so entry points add none."""


@cache
def kind_of(name: str) -> JointKind:
    """The kind of a name.

    Raises
    ------
    UnknownName
        There is no such kind; lists them.
    """
    method = JOINT_KINDS[name]
    kind: JointKind = method.build(method.record())
    return kind
