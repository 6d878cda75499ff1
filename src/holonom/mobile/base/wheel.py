"""One wheel of a base, and the table of kinds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from holonom.arrays import is_finite, shown
from holonom.errors import ModelError, UnknownName
from holonom.mobile.equations.wheels import Row, rolling_row, sliding_row, spin_row, swedish_row, unit
from holonom.trace import Number

__all__ = ["KINDS", "Kind", "Wheel"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheel:
    """A wheel in the polar parametrisation of Siegwart & Nourbakhsh 3.2.3; `Wheel.at` takes a place and a heading.

    Parameters
    ----------
    kind
        "fixed", "steered", "castor", "swedish", "skid", "spherical" or "ball": a name of `KINDS`.
    l, alpha
        Distance (m) and direction (rad) of the wheel from the origin of base_link; of a castor, of its pivot.
    beta
        Angle of the axle against that direction, rad. The axle points along alpha + beta, to the left of the wheel; it
        rolls along u = (sin(alpha+beta), -cos(alpha+beta)). Of a steered wheel and a castor, the angle at rest.
    radius
        Wheel radius r, m.
    roller_angle
        Of a Swedish wheel, gamma: 0 for an omni wheel, +-pi/4 for a mecanum wheel; not +-pi/2.
    castor_offset
        Of a castor, d: the floor is touched at pivot + d u. It trails a base that moves along -u where d > 0.
    acts_at
        Of a skidding wheel, (x, y), m, where a wheel that only rolls would stand to move the base as it does: its
        centre of rotation. None: where it stands.
    driven
        Whether a motor turns it (for a driven sphere: three, for a ball two, see `KINDS`). A driven castor has a second
        one at its pivot: it moves the base in every direction at once, at any angle.
    max_steering
        Of a steered wheel, how far it turns to either side of beta, rad, at most pi/2; None: all around.
    name
        What errors and figures call it; `WheelBase` numbers the nameless.

    Raises
    ------
    ModelError
        A number that is none, radius not above zero, a roller that lies along the wheel, a castor without offset.
    UnknownName
        No such kind.
    """

    kind: str
    l: float
    alpha: float
    beta: float
    radius: float
    roller_angle: float = 0.0
    castor_offset: float = 0.0
    acts_at: tuple[float, float] | None = None
    driven: bool = False
    max_steering: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise UnknownName("kind of wheel", str(self.kind), KINDS)
        called = f"wheel {self.name!r}" if self.name else f"a {self.kind} wheel"
        for field in ("l", "alpha", "beta", "radius", "roller_angle", "castor_offset"):
            _finite(called, field, getattr(self, field))
        if self.radius <= 0.0:
            raise ModelError(f"{called} has radius {self.radius} m; state one above zero")
        if self.l < 0.0:
            raise ModelError(
                f"{called} stands at distance l = {self.l} m; state one that is not below zero, turn alpha"
            )
        self._check_kind(called)

    def _check_kind(self, called: str) -> None:
        if self.kind == "swedish" and abs(math.cos(self.roller_angle)) < 1e-3:
            raise ModelError(
                f"{called} has rollers at {math.degrees(self.roller_angle):.6g} deg, whose axles lie across the wheel: "
                "its motor moves nothing; omni wheels have 0, mecanum wheels +-45 deg"
            )
        if self.kind == "castor" and self.castor_offset == 0.0:
            raise ModelError(f"{called} has castor_offset 0; state its trail in m, or make it a steered wheel")
        _only(called, self.kind, "swedish", "roller_angle", self.roller_angle != 0.0)
        _only(called, self.kind, "castor", "castor_offset", self.castor_offset != 0.0)
        _only(called, self.kind, "steered", "max_steering", self.max_steering is not None)
        _only(called, self.kind, "skid", "acts_at", self.acts_at is not None)
        for field, value in zip(("x", "y"), self.acts_at or (), strict=False):
            _finite(called, f"acts_at ({field})", value)
        limit = self.max_steering
        if limit is not None and not (is_finite(limit) and 0.0 < limit <= math.pi / 2 + 1e-12):
            raise ModelError(f"{called} has max_steering {shown(limit)}; allowed is 0 to pi/2 rad, or None")

    @classmethod
    def at(
        cls, kind: str, x: float, y: float, heading: float = 0.0, *, radius: float, roller_angle: float = 0.0,
        castor_offset: float = 0.0, acts_at: tuple[float, float] | None = None, driven: bool = False,
        max_steering: float | None = None, name: str = "",
    ) -> Wheel:  # fmt: skip
        """Return a wheel at (x, y), m, that rolls along `heading`, rad from x, counter-clockwise (psi).

        beta = psi + pi/2 - alpha; the rest as in the class.
        """
        called = f"wheel {name!r}" if name else f"a {kind} wheel"
        for field, value in (("x", x), ("y", y), ("heading", heading)):
            _finite(called, field, value)
        l, alpha = math.hypot(x, y), math.atan2(y, x)
        return cls(
            kind=kind, l=l, alpha=alpha, beta=heading + math.pi / 2 - alpha, radius=radius, roller_angle=roller_angle,
            castor_offset=castor_offset, acts_at=acts_at, driven=driven, max_steering=max_steering, name=name,
        )  # fmt: skip

    @property
    def x(self) -> float:
        """Place forwards of the origin of base_link, m."""
        return self.l * unit(self.alpha)[1]

    @property
    def y(self) -> float:
        """Place to the left of the origin of base_link, m."""
        return self.l * unit(self.alpha)[0]

    @property
    def steers(self) -> bool:
        """Whether a motor turns it about its vertical axis: a steered wheel, a driven castor."""
        return self.kind == "steered" or self.powered_castor

    @property
    def powered_castor(self) -> bool:
        """Whether it is a castor whose wheel and pivot have motors: it rolls, and swings, as the base moves."""
        return self.kind == "castor" and self.driven

    @property
    def acting(self) -> tuple[float, float]:
        """Where its rows are taken, m: where it stands, but of a skidding wheel its centre of rotation."""
        return self.acts_at or (self.x, self.y)

    @property
    def axle(self) -> float:
        """Direction of the axle, alpha + beta, rad; to the left of the wheel."""
        return self.alpha + self.beta

    @property
    def heading(self) -> float:
        """Direction in which it rolls, psi = alpha + beta - pi/2, rad (of a steered wheel at rest)."""
        return self.axle - math.pi / 2


class Kind(NamedTuple):
    """What a kind of wheel contributes: its rows for the sine and cosine of alpha + beta, one speed per rolling row.

    `speeds` holds what is added to the wheel's name for each of its rolling rows.
    """

    rolling: Callable[[Wheel, Number, Number], list[Row]]
    sliding: Callable[[Wheel, Number, Number], list[Row]]
    speeds: Callable[[Wheel], tuple[str, ...]]


def _finite(called: str, field: str, value: object) -> None:
    if not is_finite(value):
        raise ModelError(f"{called} has {field} = {shown(value)}; a finite number is needed")


def _only(called: str, kind: str, allowed: str, field: str, stated: bool) -> None:
    if stated and kind != allowed:
        raise ModelError(f"{called} is {kind} and states {field}; only {allowed} wheels have one")


def _roll(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    return [rolling_row(*wheel.acting, s, c)]


def _slide(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    return [sliding_row(*wheel.acting, s, c)]


def _none(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    return []


def _castor(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    """Its rim runs as its pivot moves along it: turning about the pivot adds nothing."""
    return _roll(wheel, s, c) if wheel.driven else []


def _swedish(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    return [swedish_row(wheel.x, wheel.y, wheel.axle, wheel.roller_angle)]


def _sphere(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    """A driven ball rolls along its heading, along its axle, and is spun about the vertical."""
    return [*_ball(wheel, s, c), spin_row(wheel.radius)] if wheel.driven else []


def _ball(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    """A ball that bears a body alone rolls along its heading and along its axle."""
    return [*_roll(wheel, s, c), *_slide(wheel, s, c)]


def _no_spin(wheel: Wheel, s: Number, c: Number) -> list[Row]:
    """The floor holds it against turning about the vertical."""
    return [spin_row(wheel.radius)]


KINDS: Mapping[str, Kind] = {
    "fixed": Kind(_roll, _slide, lambda wheel: ("",)),
    "steered": Kind(_roll, _slide, lambda wheel: ("",)),
    "castor": Kind(_castor, _none, lambda wheel: ("",) if wheel.driven else ()),
    "swedish": Kind(_swedish, _none, lambda wheel: ("",)),
    "skid": Kind(_roll, _slide, lambda wheel: ("",)),
    "spherical": Kind(_sphere, _none, lambda wheel: (" along", " across", " spin") if wheel.driven else ()),
    "ball": Kind(_ball, _no_spin, lambda wheel: (" along", " across")),
}
"""A kind of wheel is its rows and one line here. A castor, driven or not, and a passive sphere follow any twist."""
