"""Kernels of `mechanics.jacobians`: rates and Hessian of the Jacobian by differentiating its graph."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from holonom.errors import UnknownName
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.vectors import Matrix, Vector, matmul, matvec
from holonom.mechanics.kernels.placement import Here, compile_here
from holonom.mechanics.kernels.results import AnalyticJacobian
from holonom.model import ArmModel
from holonom.trace import Kernel, Number, Scalar, less, select, sqrt
from holonom.trace.derivative import along, jacobian

__all__ = ["FRAMED", "JACOBIANS", "frame_named"]

Options = Mapping[str, Any]
DEGENERATE = 1e-9
"""Sine (ZYZ) or cosine (RPY) of the middle angle below which the rates of the angles are not defined."""


def _flat(rows: Matrix) -> list[Number]:
    return [entry for row in rows for entry in row]


def _scalars(values: Vector) -> list[Scalar]:
    return [v for v in values if isinstance(v, Scalar)]


def frame_named(options: Options, *, own: bool = False) -> str:
    """The frame of a Jacobian, one of three; `own`: or the one that it is the Jacobian of."""
    frame = str(options.get("frame", "world"))
    known = ("world", "base", "tool", *(("own",) if own else ()))
    if frame not in known:
        raise UnknownName("Jacobian frame", frame, known)
    return frame


def _jacobian_rate(model: ArmModel, options: Options) -> Kernel:
    n, frame = len(model.independent), frame_named(options)
    return compile_here(
        model,
        options,
        lambda here, q, qd: along(kinematics.jacobian(here.model, q, frame), _scalars(q), qd),
        {"q": n, "qd": n},
        {"Jd": (6, n)},
        name=f"jacobian_rate_{frame}",
    )


def _acceleration_bias(model: ArmModel, options: Options) -> Kernel:
    """Jdot qd as the rate of J qd with qd held: without Jdot."""
    n, frame = len(model.independent), frame_named(options)

    def equation(here: Here, q: Vector, qd: Vector) -> list[Number]:
        J = kinematics.jacobian(here.model, q, frame)
        return along(matvec([J[n * i : n * i + n] for i in range(6)], qd), _scalars(q), qd)

    name = f"acceleration_bias_{frame}"
    return compile_here(model, options, equation, {"q": n, "qd": n}, {"a": 6}, name=name)


def _jacobian_hessian(model: ArmModel, options: Options) -> Kernel:
    n, frame = len(model.independent), frame_named(options)
    return compile_here(
        model,
        options,
        lambda here, q: _flat(jacobian(kinematics.jacobian(here.model, q, frame), _scalars(q))),
        {"q": n},
        {"H": (6, n, n)},
        name=f"jacobian_hessian_{frame}",
    )


def _analytic_jacobian(model: ArmModel, options: Options) -> Kernel:
    n, angles = len(model.independent), options.get("angles")
    if angles not in ("zyz", "rpy"):
        raise UnknownName("angles", str(angles), ("zyz", "rpy"))

    def equation(here: Here, q: Vector) -> list[list[Number]]:
        J = kinematics.jacobian(here.model, q, "world")
        R, _ = kinematics.frames(here.model, q)[-1]
        rows = [J[n * i : n * i + n] for i in range(6)]
        rates, degenerate = _angle_rates(R, angles)
        return [_flat([*rows[:3], *matmul(rates, rows[3:])]), [degenerate]]

    outputs: dict[str, int | tuple[int, ...]] = {"J": (6, n), "degenerate": ()}
    return compile_here(
        model,
        options,
        equation,
        {"q": n},
        outputs,
        name=f"analytic_jacobian_{angles}",
        integers=("degenerate",),
        result=lambda J, degenerate: AnalyticJacobian(J, degenerate.view(bool)),
    )


def _angle_rates(R: Matrix, angles: str) -> tuple[Matrix, Number]:
    """Angle rates from the angular velocity in the world, (3, 3); zero and 1 where they are not defined.

    Siciliano 3.6. With the node line turned by phi about z: theta' = w . n, psi' = (w along the turned axis) / s.
    """
    x, y, lift = (R[0][2], R[1][2], R[2][2]) if angles == "zyz" else (R[0][0], R[1][0], R[2][0])
    s = sqrt(x * x + y * y)
    flat = less(s, DEGENERATE)
    inverse = select(flat, 0.0, 1.0 / select(flat, 1.0, s))
    c_phi, s_phi = x * inverse, y * inverse
    last: list[Number] = [c_phi * inverse, s_phi * inverse, 0.0]
    first: list[Number] = [-lift * last[0], -lift * last[1], select(flat, 0.0, 1.0)]
    middle: list[Number] = [-s_phi, c_phi, 0.0]
    rows = [first, middle, last] if angles == "zyz" else [last, middle, first]
    return rows, select(flat, 1.0, 0.0)


JACOBIANS: Mapping[str, Callable[[ArmModel, Options], Kernel]] = {
    "jacobian_rate": _jacobian_rate,
    "acceleration_bias": _acceleration_bias,
    "jacobian_hessian": _jacobian_hessian,
    "analytic_jacobian": _analytic_jacobian,
}
FRAMED = ("jacobian_rate", "acceleration_bias", "jacobian_hessian")
"""Those that are stated in a frame."""
