"""What is calibrated of each drive: named numbers, and the motion matrix they make.

The motion matrix M (3, f) turns the features of a sample (wheel turns; of a steered wheel turn times cosine and turn
times sine of its angle) into the increment of the base. Two sets for each drive: `physical`, what a data sheet states,
and `extended`, which also finds the place of the frame that the truth is of (a marker is never quite on the base's
frame), the angle of mecanum rollers, and of an omni3 drive every wheel's own direction and lever.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from holonom.arrays import Array
from holonom.errors import CalibrationError, OutOfLimits, UnknownName
from holonom.mobile.calibration.runs import Motion, Run

__all__ = [
    "DRIVES", "SETS", "DriveParameters", "Parameters", "Sampled", "article", "drive_parameters", "seen_from",
    "turned_frame", "wheels_of",
]  # fmt: skip


SETS = ("physical", "extended")


class Sampled(NamedTuple):
    """A run at one set of p parameters, sample by sample.

    Attributes
    ----------
    increments, slopes : (N, 3) of the base in the truth's frame, m and rad, and their derivatives (N, 3, p).
    strain, strain_slopes : (N, k) what wheels count beyond any motion of a rigid base, rad, and its derivatives
        (N, k, p); k may be 0.
    """

    increments: Array
    slopes: Array
    strain: Array
    strain_slopes: Array


class Parameters(Protocol):
    """What is calibrated: named numbers, and the increments of a run that they make.

    `names`, `nominal` and `scale` are those of p parameters, as in `DriveParameters`.
    """

    @property
    def drive(self) -> str:
        """What is driven."""

    @property
    def set(self) -> str:
        """One of `SETS`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""

    @property
    def nominal(self) -> Array:
        """(p,)."""

    @property
    def scale(self) -> Array:
        """(p,)."""

    def sampled(self, run: Run, p: Array) -> Sampled:
        """Increments of a run, with their derivatives."""

    def motion(self, p: Array) -> Array | Motion:
        """What `dead_reckoning` takes."""


@dataclass(frozen=True, slots=True)
class DriveParameters:
    """Numbers of a drive and the motion matrix they make.

    Attributes
    ----------
    drive, set : which drive, and which of `SETS`.
    names : of the p parameters; lengths in m, angles in rad.
    nominal : (p,) what the data sheet says.
    scale : (p,) by how much each may reasonably be wrong altogether: itself, one radian, or a wheelbase.
    matrix : (p,) -> motion matrix (3, f).
    slopes : (p,) -> its derivatives (3, f, p).
    """

    drive: str
    set: str
    names: tuple[str, ...]
    nominal: Array
    scale: Array
    matrix: Callable[[Array], Array]
    slopes: Callable[[Array], Array]

    def sampled(self, run: Run, p: Array) -> Sampled:
        """Increments of a run, with their derivatives; wheels are not compared with each other."""
        features, n = run.features, len(run.time)
        by_all = np.ascontiguousarray(np.tensordot(features, self.slopes(p), axes=(1, 1)))
        return Sampled(features @ self.matrix(p).T, by_all, np.empty((n, 0)), np.empty((n, 0, len(p))))

    def motion(self, p: Array) -> Array:
        """Motion matrix (3, f)."""
        return self.matrix(p)


@dataclass(frozen=True, slots=True)
class _Wheels:
    """A drive whose increment is a sum over wheels: column j is `D/2 (g cos a, g sin a, h/L)`."""

    wheels: tuple[str, ...]
    lever: str
    gain: float
    directions: tuple[float, ...]
    turning: tuple[float, ...]


_DEG = np.pi / 180.0
_ANY = {f"omni{count}_any": count for count in (3, 4, 5, 6)}
"""Wheels of the drives whose axes stand at angles of their own."""
_FRAME = ("frame_ahead", "frame_left", "frame_yaw")
_WHEELED = {
    "differential": _Wheels(("left", "right"), "wheelbase", 0.5, (0.0, 0.0), (-1.0, 1.0)),
    "omni3": _Wheels(
        ("wheel_1", "wheel_2", "wheel_3"), "wheel_distance", 2.0 / 3.0,
        (30 * _DEG, 150 * _DEG, 270 * _DEG), (1 / 3, 1 / 3, 1 / 3),
    ),
    "mecanum": _Wheels(
        ("front_left", "front_right", "rear_left", "rear_right"), "wheelbase_plus_track", np.sqrt(2.0) / 4.0,
        (-45 * _DEG, 45 * _DEG, 45 * _DEG, -45 * _DEG), (-0.5, 0.5, -0.5, 0.5),
    ),
}  # fmt: skip


def _numbered(count: int) -> tuple[str, ...]:
    return tuple(f"wheel_{k + 1}" for k in range(count))


DRIVES = {
    **{name: (w.lever, *(f"diameter_{wheel}" for wheel in w.wheels)) for name, w in _WHEELED.items()},
    "tricycle": ("wheelbase", "diameter", "steering_offset"),
    **{
        name: ("wheel_distance", *(f"{what}_{wheel}" for what in ("diameter", "axis") for wheel in _numbered(count)))
        for name, count in _ANY.items()
    },
}
"""Physical parameters of each drive that can be calibrated.

- differential: wheels left, right, `wheelbase` apart; forward is positive.
- tricycle: one steered, driven wheel in front, `wheelbase` ahead of the axle; steering is positive to the left.
- omni3: omni wheels at -60, 60 and 180 degrees, `wheel_distance` from the middle; positive drives counter-clockwise.
- mecanum: rollers of the wheels seen from above make an X; forward is positive. `wheelbase_plus_track` is the distance
  between axles plus that between left and right wheels.
- omni3_any to omni6_any: omni wheels at `wheel_distance` from the middle, their axes pointing outwards at the angles
  `axis_wheel_1`, ..., which are taken as stated and not calibrated; positive drives counter-clockwise.
"""


def wheels_of(drive: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of a drive's wheels, and of its steered ones, in the order of a run's columns.

    Raises
    ------
    UnknownName
    """
    if drive not in DRIVES:
        raise UnknownName("drive that can be calibrated", drive, DRIVES)
    if drive in _ANY:
        return _numbered(_ANY[drive]), ()
    return (("front",), ("front",)) if drive == "tricycle" else (_WHEELED[drive].wheels, ())


def article(drive: str) -> str:
    """Return "a mecanum" or "an omni3"."""
    return f"{'an' if drive[0] in 'aeiou' else 'a'} {drive}"


def drive_parameters(drive: str, nominal: Mapping[str, float], set_name: str = "physical") -> DriveParameters:
    """Return what is calibrated of a drive.

    Parameters
    ----------
    drive : a key of `DRIVES`.
    nominal : its physical parameters by name, as `DRIVES` lists them; m and rad.
    set_name : one of `SETS`.

    Raises
    ------
    UnknownName
        No such drive or set.
    CalibrationError
        Missing or surplus parameters.
    OutOfLimits
        A length that is not above zero.
    """
    wheels_of(drive)
    if set_name not in SETS:
        raise UnknownName("set of parameters", set_name, SETS)
    if set(nominal) != set(DRIVES[drive]):
        raise CalibrationError(
            f"parameters {', '.join(sorted(nominal)) or 'none'} came; {article(drive)} has {', '.join(DRIVES[drive])}"
        )
    values = np.array([float(nominal[name]) for name in DRIVES[drive]])
    for name, value in zip(DRIVES[drive], values, strict=True):
        angle = name == "steering_offset" or name.startswith("axis_")
        if not np.isfinite(value) or (value <= 0.0 and not angle):
            raise OutOfLimits(f"{name} {value} came; a length above zero is allowed")
    if set_name == "extended" and drive == "omni3":
        return _each_wheel(drive, values)
    makes = {"tricycle": _tricycle, **dict.fromkeys(_ANY, _any)}
    plain = makes.get(drive, _wheeled)(drive, values)
    if set_name == "physical":
        return plain
    return _framed(_rollers(plain) if drive == "mecanum" else plain)


def _wheeled(drive: str, nominal: Array) -> DriveParameters:
    kind = _WHEELED[drive]
    a, h = np.array(kind.directions), np.array(kind.turning)
    return _levered(drive, nominal, 0.5 * np.stack([kind.gain * np.cos(a), kind.gain * np.sin(a), h]))


def _any(drive: str, nominal: Array) -> DriveParameters:
    """Rims run at `(-sin a, cos a, L) (vx, vy, w)`; the increment is the one that fits all wheels best."""
    count = _ANY[drive]
    axes = nominal[1 + count :]
    coupling = np.stack([-np.sin(axes), np.cos(axes), np.ones(count)], axis=1)
    if np.linalg.cond(coupling) > 1e6:
        raise CalibrationError(f"axes at {axes.tolist()} rad came; wheels at angles that drive all ways are allowed")
    return _levered(drive, nominal[: 1 + count], 0.5 * np.linalg.pinv(coupling))


def _levered(drive: str, nominal: Array, rows: Array) -> DriveParameters:
    """Common lever L, one diameter per wheel: increments are rows (3, n) times diameters, the turn over L."""
    count = rows.shape[1]

    def matrix(p: Array) -> Array:
        return rows * p[1:] / np.array([[1.0], [1.0], [p[0]]])

    def slopes(p: Array) -> Array:
        M, out = matrix(p), np.zeros((3, count, len(p)))
        out[2, :, 0] = -M[2] / p[0]
        for j in range(count):
            out[:, j, 1 + j] = M[:, j] / p[1 + j]
        return out

    return DriveParameters(drive, "physical", DRIVES[drive][: 1 + count], nominal, nominal, matrix, slopes)


def _tricycle(drive: str, nominal: Array) -> DriveParameters:
    """Wheel's way s at angle `a = steering + offset`: forwards `s cos a`, turn `s sin a / L`."""
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])

    def matrix(p: Array) -> Array:
        L, D, offset = p
        c, s = np.cos(offset), np.sin(offset)
        return 0.5 * D * np.array([[c, -s], [0.0, 0.0], [s / L, c / L]])

    def slopes(p: Array) -> Array:
        M, out = matrix(p), np.zeros((3, 2, 3))
        out[2, :, 0] = -M[2] / p[0]
        out[:, :, 1] = M / p[1]
        out[:, :, 2] = M @ turned
        return out

    scale = np.array([nominal[0], nominal[1], 1.0])
    return DriveParameters(drive, "physical", DRIVES[drive], nominal, scale, matrix, slopes)


def _rollers(plain: DriveParameters) -> DriveParameters:
    """Mecanum with rollers at another angle than 45 degrees: sideways way divided by the angle's tangent."""

    def matrix(p: Array) -> Array:
        return np.array([[1.0], [1.0 / np.tan(p[-1])], [1.0]]) * plain.matrix(p[:-1])

    def slopes(p: Array) -> Array:
        by_angle = np.zeros((3, 4, 1))
        by_angle[1, :, 0] = -plain.matrix(p[:-1])[1] / np.sin(p[-1]) ** 2
        before = np.array([1.0, 1.0 / np.tan(p[-1]), 1.0])[:, None, None] * plain.slopes(p[:-1])
        return np.concatenate([before, by_angle], axis=2)

    return DriveParameters(
        plain.drive, "extended", (*plain.names, "roller_angle"), np.append(plain.nominal, 45 * _DEG),
        np.append(plain.scale, 1.0), matrix, slopes,
    )  # fmt: skip


def _framed(plain: DriveParameters) -> DriveParameters:
    """The truth is that of a frame (a marker) at (ahead, left) of the base's own, turned by yaw."""

    def matrix(p: Array) -> Array:
        M = plain.matrix(p[:-3])
        return np.vstack([_yaw(p[-1]) @ (M[:2] + np.outer([-p[-2], p[-3]], M[2])), M[2]])

    def slopes(p: Array) -> Array:
        ahead, left, yaw = p[-3:]
        M, dM = plain.matrix(p[:-3]), plain.slopes(p[:-3])
        moved = dM[:2] + np.array([-left, ahead])[:, None, None] * dM[2]
        by_plain = np.concatenate([np.tensordot(_yaw(yaw), moved, 1), dM[2:]])
        by_frame = np.zeros((3, M.shape[1], 3))
        by_frame[:2, :, 0] = np.outer(_yaw(yaw)[:, 1], M[2])
        by_frame[:2, :, 1] = -np.outer(_yaw(yaw)[:, 0], M[2])
        by_frame[:2, :, 2] = np.array([[0.0, 1.0], [-1.0, 0.0]]) @ matrix(p)[:2]
        return np.concatenate([by_plain, by_frame], axis=2)

    L = plain.nominal[0]
    return DriveParameters(
        plain.drive, "extended", (*plain.names, *_FRAME), np.concatenate([plain.nominal, np.zeros(3)]),
        np.concatenate([plain.scale, [L, L, 1.0]]), matrix, slopes,
    )  # fmt: skip


def turned_frame(drive: Parameters, yaw: float) -> Array:
    """Unknown (p,), in scales, of nominal numbers with the truth's frame turned by yaw, rad."""
    own = "frame_yaw" not in drive.names  # no frame: all wheels stand otherwise
    sign = [1.0 if name == "frame_yaw" else -own if name.startswith("direction") else 0.0 for name in drive.names]
    return yaw * np.array(sign) / drive.scale


def seen_from(motion: Array | Motion, frame: tuple[float, float, float]) -> Array | Motion:
    """The same motion, (3, f) or a `Motion`, as a frame sees it that is ahead and to the left, m, and turned, rad."""
    if isinstance(motion, Motion):
        own, M = motion.increments, _seen(np.eye(3), frame)
        return Motion(lambda run: own(run) @ M.T, motion.lever)
    return _seen(motion, frame)


def _seen(M: Array, frame: tuple[float, float, float]) -> Array:
    ahead, left, yaw = frame
    return np.vstack([_yaw(yaw) @ (M[:2] + np.outer([-left, ahead], M[2])), M[2:]])


def _yaw(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s], [-s, c]])


def _each_wheel(drive: str, physical: Array) -> DriveParameters:
    """Every wheel with its own diameter, direction and lever: every entry of the matrix free."""
    kind = _WHEELED[drive]
    n, a, h = len(kind.wheels), np.array(kind.directions), np.array(kind.turning)

    def matrix(p: Array) -> Array:
        D, d, L = p[:n], p[n : 2 * n], p[2 * n :]
        return 0.5 * D * np.stack([kind.gain * np.cos(a + d), kind.gain * np.sin(a + d), h / L])

    def slopes(p: Array) -> Array:
        M, out = matrix(p), np.zeros((3, n, 3 * n))
        for j in range(n):
            out[:, j, j] = M[:, j] / p[j]
            out[0, j, n + j], out[1, j, n + j] = -M[1, j], M[0, j]
            out[2, j, 2 * n + j] = -M[2, j] / p[2 * n + j]
        return out

    names = tuple(f"{what}_{wheel}" for what in ("diameter", "direction", "lever") for wheel in kind.wheels)
    nominal = np.concatenate([physical[1:], np.zeros(n), np.full(n, physical[0])])
    scale = np.concatenate([physical[1:], np.ones(n), np.full(n, physical[0])])
    return DriveParameters(drive, "extended", names, nominal, scale, matrix, slopes)
