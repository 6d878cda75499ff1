"""`Arm`: a robot description together with its compiled equations."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.errors import InputError, ShapeError, UnknownName
from holonom.mechanics import inverse_geometry
from holonom.mechanics.closed_form import FAMILIES, ClosedForm, closed_form
from holonom.mechanics.equations.inertia import fixed_to_body
from holonom.mechanics.ik_result import IkCase, IkNearest, IkResult, IkStatus
from holonom.mechanics.kernels import make_kernel
from holonom.mechanics.pose_check import is_rigid
from holonom.model import ArmModel, Body, constant_transform
from holonom.spatial import check_pose
from holonom.trace import Kernel

__all__ = ["Arm", "IkCase", "IkNearest", "IkResult", "IkStatus", "Limits"]

Array = NDArray[np.float64]
FREE = 1e-8
"""Singular value of the Jacobian below which a combination of joints moves nothing."""


@dataclass(frozen=True, slots=True)
class Limits:
    """Joint limits as arrays (n,): rad, rad/s, rad/s2, N m (m, m/s, ... for prismatic joints)."""

    names: tuple[str, ...]
    lower: Array
    upper: Array
    speed: Array
    acceleration: Array
    torque: Array


class Arm:
    """A serial arm; every verb broadcasts over leading axes.

    One sample, or rows of C-contiguous float64, go the fast way.

    `threads=` shares a batch; `out=` takes a result array. Kernels are compiled on first use and cached on disk;
    `kernel(name)` hands one out for the fastest repeated calls.
    """

    def __init__(self, model: ArmModel) -> None:
        self.model = model
        self.n = len(model.independent)
        self._kernels: dict[object, Kernel] = {}
        self._has_friction = any(j.friction is not None for j in model.joints)

    def __repr__(self) -> str:
        return f"Arm({self.model.name!r}, n={self.n})"

    @property
    def limits(self) -> Limits:
        """Joint limits as arrays."""
        moving = [self.model.joints[i] for i in self.model.independent]
        bounds = [j.limits for j in moving]
        rows = [(b.lower, b.upper, b.speed, b.acceleration, b.torque) for b in bounds]
        return Limits(tuple(j.name for j in moving), *np.array(rows, dtype=float).T.copy())

    def with_tool(self, tool: ArrayLike) -> Arm:
        """Return the arm with another tool pose T_nt (4, 4)."""
        return Arm(dataclasses.replace(self.model, tool=constant_transform(check_pose(tool, "tool"))))

    def with_base(self, base: ArrayLike) -> Arm:
        """Return the arm with another base pose T_w0 (4, 4)."""
        return Arm(dataclasses.replace(self.model, base=constant_transform(check_pose(base, "base"))))

    def with_gravity(self, gravity: Sequence[float]) -> Arm:
        """Return the arm under another gravity (3,) in the world, m/s2."""
        gx, gy, gz = (float(g) for g in gravity)
        return Arm(dataclasses.replace(self.model, gravity=(gx, gy, gz)))

    def with_limits(self, *, speed: float = 1.0, acceleration: float = 1.0) -> Arm:
        """Return the arm with its joints' speed and acceleration limits scaled by factors."""
        joints = tuple(
            dataclasses.replace(
                joint,
                limits=dataclasses.replace(
                    joint.limits,
                    speed=joint.limits.speed * speed,
                    acceleration=joint.limits.acceleration * acceleration,
                ),
            )
            for joint in self.model.joints
        )
        return Arm(dataclasses.replace(self.model, joints=joints))

    def with_load(self, body: Body) -> Arm:
        """Return the arm with a body, such as a gripper, fixed to the link that carries the tool (in its frame)."""
        if self.model.bodies is None:
            return self
        bodies, tip = list(self.model.bodies), self.model.tool_joint
        bodies[tip] = fixed_to_body(bodies[tip], body)
        return Arm(dataclasses.replace(self.model, bodies=tuple(bodies)))

    def kernel(self, name: str, **options: Any) -> Kernel:
        """Return a compiled equation: "fk", "frames", "jacobian", "inverse_dynamics", "forward_dynamics", ....

        Options are those of the verb: `frame=`, `friction=`, `wrench_frame=`. The
        fastest call is `kernel.single(q, ..., out)`: see `holonom.trace.Kernel`.
        """
        asked = (name, *options.items()) if options else name
        known = self._kernels.get(asked)
        if known is not None:
            return known
        if name in ("inverse_dynamics", "forward_dynamics"):
            options = {"friction": self._has_friction, "wrench_frame": None} | options
        elif name == "fk":
            options = {"frame": "tool"} | options
        elif name == "jacobian":
            options = {"frame": "world"} | options
        key = (name, *sorted(options.items()))
        if key not in self._kernels:
            self._kernels[key] = make_kernel(name, self.model, options)
        self._kernels[asked] = self._kernels[key]
        return self._kernels[key]

    def fk(self, q: ArrayLike, frame: str = "tool", *, out: Array | None = None, threads: int = 1) -> Array:
        """Forward kinematics.

        Parameters
        ----------
        q : (..., n) rad or m.
        frame : "tool", "base", "link1" .. "link{n}" or a frame that the model names.

        Returns
        -------
        T_w(frame) : (..., 4, 4).
        """
        kernel = self._kernels.get(("fk", frame))
        if kernel is None:
            kernel = self._kernels["fk", frame] = self.kernel("fk", frame=frame)
        result: Array = kernel(q, out=out, threads=threads)
        return result

    def frames(self, q: ArrayLike) -> Array:
        """World poses of base, link1 .. link{n} and tool: (..., n + 2, 4, 4)."""
        result: Array = self.kernel("frames")(q)
        return result

    def jacobian(self, q: ArrayLike, frame: str = "world", *, out: Array | None = None, threads: int = 1) -> Array:
        """Geometric Jacobian of the tool point, rows [v; w] (Siciliano 3.1).

        Parameters
        ----------
        q : (..., n).
        frame : "world", "base" or "tool", the frame in which v and w are expressed.

        Returns
        -------
        J : (..., 6, n).
        """
        kernel = self._kernels.get(("jacobian", frame))
        if kernel is None:
            if frame not in ("world", "base", "tool"):
                raise UnknownName("Jacobian frame", frame, ("world", "base", "tool"))
            kernel = self._kernels["jacobian", frame] = self.kernel("jacobian", frame=frame)
        result: Array = kernel(q, out=out, threads=threads)
        return result

    @functools.cached_property
    def closed_form(self) -> ClosedForm | None:
        """The closed-form inverse that fits how the arm's axes lie, if there is one."""
        return closed_form(self.model)

    def ik(self, T: ArrayLike, *, threads: int = 1) -> IkResult:
        """Closed-form inverse geometry: every branch with its status, proved by forward kinematics.

        Parameters
        ----------
        T : (..., 4, 4), T_wt. Arms that can only place their tool (two joints in a plane, three joints in space:
            `closed_form.task` is "position") take points p_wt (..., 3) too, and of a pose its place.

        Raises
        ------
        NotAPose, ShapeError
            `T` is no rigid transform; NaN.
        InputError
            No closed form for this arm.
        """
        form = self._form()
        target = self._target(T, form)
        q, status = self.kernel("inverse_geometry")(target, threads=threads)
        if not form.exact:
            bounds = self.limits.lower, self.limits.upper
            q, status = inverse_geometry.refined(self.fk, self.jacobian, bounds, form.task, target, q, status)
        return IkResult(q, status, form.names)

    def _form(self) -> ClosedForm:
        if self.closed_form is None:
            raise InputError(
                f"arm {self.model.name!r} has no closed-form inverse: its axes lie like none of {', '.join(FAMILIES)}; "
                "ik_nearest(T, q0) finds one solution numerically"
            )
        return self.closed_form

    def _target(self, T: ArrayLike, form: ClosedForm) -> Array:
        target = np.asarray(T, dtype=float)
        if form.task == "pose":
            one = target.shape == (4, 4) and target.flags.c_contiguous
            return target if one and is_rigid(target) else check_pose(T, "T")
        return target if target.shape[-1:] == (3,) else check_pose(T, "T")[..., :3, 3]

    def ik_nearest(self, T: ArrayLike, q0: ArrayLike, *, weights: ArrayLike | None = None) -> IkNearest:
        """The reachable branch nearest to `q0`, with joints whole turns away where limits allow.

        Without a closed form the numerical solver starts from `q0` (`mechanics.numerical_inverse`).

        Parameters
        ----------
        T : (..., 4, 4), as for `ik`.
        q0 : (..., n).
        weights : (n,), what a joint's difference counts; the largest weighted difference is the distance. Default 1.

        Returns
        -------
        `status` is that of the branch taken: OK or SINGULAR, and LIMIT or UNREACHABLE if no branch is better.
        """
        reference = np.asarray(q0, dtype=float)
        if reference.shape[-1:] != (self.n,) or not np.isfinite(reference).all():
            raise ShapeError(f"q0 must be finite and of shape (..., {self.n}); shape {reference.shape} came")
        weight = np.ones(self.n) if weights is None else np.asarray(weights, dtype=float)
        if weight.shape != (self.n,) or not (weight >= 0.0).all():
            raise ShapeError(f"weights must be {self.n} numbers, none negative or NaN; shape {weight.shape} came")
        if self.closed_form is None:
            return self._searched(T, reference)
        found = self.ik(T)
        q = self._turned(found.q, reference[..., None, :])
        rank = np.array([0.0, 2e6, 1e6, 0.0])[found.status]
        branch = np.argmin((weight * np.abs(q - reference[..., None, :])).max(-1) + rank, axis=-1)
        taken = np.take_along_axis(q, branch[..., None, None], -2)[..., 0, :]
        status = np.take_along_axis(found.status, branch[..., None], -1)[..., 0]
        return IkNearest(self._kept(T, taken, reference, status), status, branch, found.names)

    def _kept(self, T: ArrayLike, q: Array, reference: Array, status: NDArray[np.int8]) -> Array:
        """Singular branches with their free joints as in the reference, where that holds the pose."""
        singular = status == IkStatus.SINGULAR
        if not singular.any():
            return q
        _, s, Vt = np.linalg.svd(self.jacobian(q))
        free = np.where(s[..., None] < FREE, Vt, 0.0)
        moved = q + np.einsum("...ki,...kj,...j->...i", free, free, reference - q)
        inside = ((moved >= self.limits.lower) & (moved <= self.limits.upper)).all(-1)
        holds = np.abs(self.fk(moved) - np.asarray(T)).max((-1, -2)) < 1e-8
        return np.where((singular & inside & holds)[..., None], moved, q)

    def _searched(self, T: ArrayLike, q0: Array) -> IkNearest:
        """What the numerical solver finds from q0."""
        from holonom.mechanics.numerical_inverse import InverseStatus, solve_inverse

        found = solve_inverse(self, T, q0)
        named = {
            InverseStatus.OK: IkStatus.OK,
            InverseStatus.NOT_CONVERGED: IkStatus.UNREACHABLE,
            InverseStatus.LIMIT: IkStatus.LIMIT,
        }
        status = np.array([named[s] for s in InverseStatus], dtype=np.int8)[found.status]
        return IkNearest(found.q, status, np.full(status.shape, -1), ())

    def _turned(self, q: Array, reference: Array) -> Array:
        """Whole turns nearer to the reference, where that stays within the limits."""
        limits = self.limits
        turns = np.array([2.0 * np.pi * (self.model.joints[i].kind == "revolute") for i in self.model.independent])
        turned = q + turns * np.round((reference - q) / (2.0 * np.pi))
        return np.where((turned >= limits.lower) & (turned <= limits.upper), turned, q)

    def inverse_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        friction: bool | None = None,
        wrench: ArrayLike | None = None,
        wrench_frame: str | None = None,
        out: Array | None = None,
        threads: int = 1,
    ) -> Array:
        """Joint torques for a motion: tau = B qdd + C qd + Fv qd + Fs sgn(qd) + g + J^T h (specification 02).

        Parameters
        ----------
        q, qd, qdd : (..., n) rad, rad/s, rad/s2.
        friction : whether joint friction is in; by default where the model has any.
        wrench : (..., 6) [f; m], what the arm exerts on its environment at the tool point, N and N m.
        wrench_frame : "world" or "tool", required with `wrench`.

        Returns
        -------
        tau : (..., n) N m.

        Raises
        ------
        ShapeError, MissingInertia, InputError
        """
        kernel = self._dynamics("inverse_dynamics", friction, wrench, wrench_frame)
        result: Array
        if wrench is None:
            result = kernel(q, qd, qdd, out=out, threads=threads)
        else:
            result = kernel(q, qd, qdd, wrench, out=out, threads=threads)
        return result

    def forward_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        *,
        friction: bool | None = None,
        wrench: ArrayLike | None = None,
        wrench_frame: str | None = None,
        out: Array | None = None,
        threads: int = 1,
    ) -> Array:
        """Joint accelerations under joint torques; arguments as for `inverse_dynamics`.

        Returns
        -------
        qdd : (..., n) rad/s2.
        """
        kernel = self._dynamics("forward_dynamics", friction, wrench, wrench_frame)
        result: Array
        if wrench is None:
            result = kernel(q, qd, tau, out=out, threads=threads)
        else:
            result = kernel(q, qd, tau, wrench, out=out, threads=threads)
        return result

    def _dynamics(self, name: str, friction: bool | None, wrench: ArrayLike | None, wrench_frame: str | None) -> Kernel:
        key = (name, friction, wrench_frame)
        kernel = self._kernels.get(key)
        if (wrench is None) != (wrench_frame is None):
            raise InputError('wrench= and wrench_frame= ("world" or "tool") go together; one of them is missing')
        if kernel is None:
            if wrench_frame not in (None, "world", "tool"):
                raise UnknownName("wrench frame", str(wrench_frame), ("world", "tool"))
            with_friction = self._has_friction if friction is None else bool(friction)
            kernel = self._kernels[key] = self.kernel(name, friction=with_friction, wrench_frame=wrench_frame)
        return kernel

    def mass_matrix(self, q: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """B(q): (..., n, n), with reflected rotor inertia on the diagonal."""
        result: Array = self.kernel("mass_matrix")(q, out=out, threads=threads)
        return result

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """C(q, qd), (..., n, n), by Christoffel symbols: Bdot - 2 C is skew-symmetric; C qd are torques, N m."""
        result: Array = self.kernel("coriolis_matrix")(q, qd, out=out, threads=threads)
        return result

    def gravity(self, q: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """Torques that hold the arm at rest: (..., n) N m."""
        result: Array = self.kernel("gravity")(q, out=out, threads=threads)
        return result
