"""`Arm`: a robot description together with its compiled equations."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Sequence
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import InputError
from holonom.mechanics.arm.beside import Beside
from holonom.mechanics.arm.branches import Branches
from holonom.mechanics.arm.limits import LimitValues, changed_limits
from holonom.mechanics.arm.placement import NO_LOAD, Placement
from holonom.mechanics.equations.dynamics.inertia import Inertial, fixed_to_body, from_body, merged
from holonom.mechanics.kernels.inverse.closed_form import ClosedForm, closed_form
from holonom.mechanics.kernels.inverse.result import IkCase, IkNearest, IkResult, IkStatus
from holonom.mechanics.kernels.protocol import Limits
from holonom.mechanics.kernels.table import OPTIONS, Calls, make_kernel, named
from holonom.model import ArmModel, Body, constant_transform, tool_chain
from holonom.spatial import check_pose
from holonom.trace import Kernel

__all__ = ["Arm", "IkCase", "IkNearest", "IkResult", "IkStatus", "Limits"]


class Prepared(dict[Any, Any]):
    """What is prepared for an arm once, kernels too: `prepared[build, option]` is what `build(arm, option)` gave."""

    def __init__(self, arm: Arm) -> None:
        super().__init__()
        self._arm = arm

    def __missing__(self, key: Any) -> Any:
        build, *options = key if isinstance(key, tuple) else (key,)
        found = self[key] = build(self._arm, *options)
        return found


class Arm:
    """A serial arm; every verb broadcasts over leading axes.

    One sample, or rows of C-contiguous float64, go the fast way.

    `threads=` shares a batch; `out=` takes a result array. Kernels are compiled on first use and cached on disk;
    `kernel(name)` hands one out for the fastest repeated calls. `calls` holds those of the verbs, `prepared` all that
    they need more than once.
    """

    def __init__(self, model: ArmModel) -> None:
        self.model = model
        self.n = len(model.independent)
        self.calls = Calls(self._call)
        self.prepared = Prepared(self)
        self.first: Arm = self
        self.placement: Placement | None = None

    def __reduce__(self) -> tuple[type[Arm], tuple[ArmModel]]:
        return Arm, (self.model,)  # a copy, or another process, compiles for itself

    def __repr__(self) -> str:
        tool = f", tool={self.model.tool_name!r}" if self.model.tool_name else ""
        return f"Arm({self.model.name!r}, n={self.n}{tool})"

    @property
    def limits(self) -> Limits:
        """Joint limits as arrays."""
        model = self.model
        bounds = [model.limits(i) for i in model.independent]
        rows = [(b.lower, b.upper, b.speed, b.acceleration, b.torque) for b in bounds]
        names, turns = zip(*((model.joints[i].name, model.joints[i].turns) for i in model.independent), strict=True)
        lower, upper, speed, acceleration, torque = np.array(rows, dtype=float).T.copy()
        return Limits(names, lower, upper, speed, acceleration, torque, turns)

    def with_tool(self, tool: ArrayLike) -> Arm:
        """Return the arm with another tool pose T_nt (4, 4)."""
        return self._placed(tool=constant_transform(check_pose(tool, "tool")))

    def with_base(self, base: ArrayLike) -> Arm:
        """Return the arm with another base pose T_w0 (4, 4)."""
        return self._placed(base=constant_transform(check_pose(base, "base")))

    def with_gravity(self, gravity: Sequence[float]) -> Arm:
        """Return the arm under another gravity (3,) in the world, m/s2."""
        gx, gy, gz = (float(g) for g in gravity)
        return self._placed(gravity=(gx, gy, gz))

    def with_load(self, body: Body) -> Arm:
        """Return the arm with a body, such as a gripper, fixed to the link that carries the tool (in its frame)."""
        if self.model.bodies is None:
            return self
        bodies, tip = list(self.model.bodies), self.model.tool_joint
        bodies[tip] = fixed_to_body(bodies[tip], body)
        return self._placed(from_body(body), bodies=tuple(bodies))

    def _placed(self, load: Inertial | None = None, **changes: Any) -> Arm:
        """The arm with another base, tool, gravity or load: `first`, whose kernels it uses, takes them as inputs."""
        arm, first = Arm(dataclasses.replace(self.model, **changes)), self.first
        carried = NO_LOAD if self.placement is None else self.placement.payload
        payload = carried if load is None else merged(carried, load)
        arm.first, arm.placement = first, Placement(first.model, first.calls, first.kernel, arm.model, payload)
        arm.calls = arm.placement.calls
        return arm

    def with_limits(self, *, speed: float = 1.0, acceleration: float = 1.0, **values: Unpack[LimitValues]) -> Arm:
        """Return the arm with other joint limits; those of joints that follow count as before (`ArmModel.limits`).

        Parameters
        ----------
        speed, acceleration : factors of all joints' limits, positive.
        values : `lower`, `upper`, `speeds`, `accelerations`, `torques`: limits (n,) or one for all, rad or m and N m or
            N; such as the accelerations that URDF files do not state. Factors count on top of them.

        Raises
        ------
        InputError, ShapeError, UnknownName
            A factor of a limit that is not stated; values of another shape, or out of order; no such limit.
        """
        return self.remade(joints=changed_limits(self.model, speed, acceleration, values))

    def remade(self, **changes: Any) -> Arm:
        """Return the arm with other parts of its model, such as `joints` of other limits; it stands where it stands."""
        arm = Arm(dataclasses.replace(self.first.model, **changes))
        if self.placement is None:
            return arm
        here = self.model
        payload = self.placement.payload
        return arm._placed(payload, base=here.base, tool=here.tool, gravity=here.gravity, bodies=here.bodies)

    def kernel(self, name: str, **options: Any) -> Kernel:
        """Return a compiled equation: "fk", "frames", "jacobian", "inverse_dynamics", "forward_dynamics", ....

        Options are those of the verb: `frame=`, `friction=`, `wrench_frame=`; `given=("base", "tool", "gravity",
        "payload")`, or some of them, makes these inputs after its own, a value for each row if need be. The fastest
        call is `kernel.single(q, ..., out)`: see `holonom.trace.Kernel`.
        """
        chosen = {**OPTIONS.get(name, {}), **options}
        if chosen.get("friction", 0) is None:
            chosen["friction"] = any(joint.friction is not None for joint in self.model.joints)
        found: Kernel = self.prepared[_kernel, name, *sorted(chosen.items())]
        return found

    def pointer(self, name: str, **options: Any) -> tuple[int, Array]:
        """Address of a compiled equation in C form, and the numbers after its own inputs: where the arm stands."""
        if self.placement is None:
            return self.kernel(name, **options).address, np.empty(0)
        kernel, more = self.placement.kernel(name, **options)
        return kernel.address, np.concatenate([np.empty(0), *(a.ravel() for a in more)])

    def _call(self, key: Any) -> Callable[..., Any]:
        name, options = named(key)
        return self.kernel(name, **options).call

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
        result: Array = self.calls["fk", frame](q, out=out, threads=threads)
        return result

    def frames(self, q: ArrayLike) -> Array:
        """World poses of base, link1 .. link{n} and tool: (..., n + 2, 4, 4)."""
        result: Array = self.calls["frames"](q)
        return result

    def jacobian(
        self,
        q: ArrayLike,
        frame: str = "world",
        *,
        of: str | tuple[str, ...] = "tool",
        out: Array | None = None,
        threads: int = 1,
    ) -> Array:
        """Geometric Jacobian of a frame's origin, rows [v; w] (Siciliano 3.1).

        Parameters
        ----------
        q : (..., n).
        frame : "world", "base", "tool" or "own" (that of `of`), the frame in which v and w are expressed.
        of : a frame as for `fk`, or several of them at once, such as both tools of a tree. Of another point:
            `mechanics.jacobians.point_jacobian`.

        Returns
        -------
        J : (..., 6, n); of m frames (..., m, 6, n).
        """
        result: Array = self.calls["jacobian", frame, of](q, out=out, threads=threads)
        return result

    @functools.cached_property
    def closed_form(self) -> ClosedForm | None:
        """The closed-form inverse that fits how the axes between base and tool lie, if there is one."""
        if self.chain is not None:
            return self.chain.chain.closed_form
        return closed_form(self.model) if self.placement is None or not self._alike else self.first.closed_form

    @functools.cached_property
    def chain(self) -> Beside | None:
        """The joints that move the tool, where others hang beside them."""
        found = tool_chain(self.model)
        return None if found is None else Beside(self, self._chain_arm, found.places)

    @functools.cached_property
    def _chain_arm(self) -> Arm:
        if self.placement is not None:
            here = self.model
            return self.first._chain_arm._placed(base=here.base, tool=here.tool, gravity=here.gravity)
        found = tool_chain(self.model)
        assert found is not None
        return Arm(found.model)

    @functools.cached_property
    def _alike(self) -> bool:
        """Whether what the first arm has to reach follows from what this one has."""
        form = self.first.closed_form
        return form is None or form.task == "pose" or (self.placement is not None and self.placement.same_tool)

    def ik(self, T: ArrayLike, q0: ArrayLike | None = None, *, threads: int = 1) -> IkResult:
        """Closed-form inverse geometry: every branch with its status, proved by forward kinematics.

        Parameters
        ----------
        T : (..., 4, 4), T_wt. Arms that can only place their tool (two joints in a plane, three joints in space:
            `closed_form.task` is "position") take points p_wt (..., 3) too, and of a pose its place.
        q0 : (..., n), what joints beside the way to the tool (a gripper's, say) have; 0 unless given.

        Raises
        ------
        NotAPose, ShapeError
            `T` is no rigid transform; NaN.
        InputError
            No closed form for this arm.
        """
        return self._branches(T, q0, threads)

    @functools.cached_property
    def _branches(self) -> Callable[[ArrayLike, ArrayLike | None, int], IkResult]:
        if self.chain is not None and self.closed_form is not None:
            return self.chain.ik
        return Branches(self, self._inverse_call).take

    def _inverse_call(self) -> Callable[..., Any]:
        """The call of the compiled inverse; placed elsewhere, the first arm's, for where its tool would be."""
        place = self.placement
        if place is None:
            return self.calls["inverse_geometry"]
        if not self._alike:
            return Arm(self.model).calls["inverse_geometry"]
        first = self.first.calls["inverse_geometry"]
        return lambda target, threads: first(place.from_first(target), threads=threads)

    def ik_nearest(
        self, T: ArrayLike, q0: ArrayLike, *, weights: ArrayLike | None = None, threads: int = 1
    ) -> IkNearest:
        """The solution nearest to `q0`, of all branches, their whole turns within the limits and their free joints.

        Without a closed form the target is approached from `q0` (`mechanics.arm.searched`): the solution nearest there.

        Parameters
        ----------
        T : (..., 4, 4), as for `ik`.
        q0 : (..., n).
        weights : (n,), what a joint's difference counts; the largest weighted difference is the distance. Default 1.
        threads : threads that share a batch, 1 or more.

        Returns
        -------
        `status` is that of the branch taken: OK or SINGULAR, and LIMIT or UNREACHABLE if no branch is better. Without a
        closed form FAR says that `q` reaches the target with a jump from `q0`: a nearer solution may exist.

        Raises
        ------
        NotAPose, ShapeError
            As for `ik`; `q0` of another shape, or with a number that is not finite, which is named.
        InputError
            `threads` is no whole number of at least 1.
        """
        return self._nearest(T, q0, weights, threads)

    @functools.cached_property
    def _nearest(self) -> Callable[[ArrayLike, ArrayLike, ArrayLike | None, int], IkNearest]:
        if self.chain is not None and self.closed_form is not None:
            return self.chain.ik_nearest
        if self.closed_form is None:
            from holonom.mechanics.arm.searched import Searched

            return Searched(self).take
        from holonom.mechanics.arm.nearest import Nearest  # compiled code, on first use

        place = self.placement
        if place is None:
            return Nearest(self).take
        if not self._alike:
            return Arm(self.model)._nearest
        take = self.first._nearest
        return lambda T, q0, weights, threads: take(place.from_first(T), q0, weights, threads)

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
        call = self.calls["inverse_dynamics", friction, wrench_frame]
        result: Array
        if wrench is None is wrench_frame:
            result = call(q, qd, qdd, out=out, threads=threads)
        elif wrench is None or wrench_frame is None:
            raise InputError('wrench= and wrench_frame= ("world" or "tool") go together; one of them is missing')
        else:
            result = call(q, qd, qdd, wrench, out=out, threads=threads)
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
        call = self.calls["forward_dynamics", friction, wrench_frame]
        result: Array
        if wrench is None is wrench_frame:
            result = call(q, qd, tau, out=out, threads=threads)
        elif wrench is None or wrench_frame is None:
            raise InputError('wrench= and wrench_frame= ("world" or "tool") go together; one of them is missing')
        else:
            result = call(q, qd, tau, wrench, out=out, threads=threads)
        return result

    def mass_matrix(self, q: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """B(q): (..., n, n), with reflected rotor inertia on the diagonal."""
        result: Array = self.calls["mass_matrix"](q, out=out, threads=threads)
        return result

    def coriolis_matrix(self, q: ArrayLike, qd: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """C(q, qd), (..., n, n), by Christoffel symbols: Bdot - 2 C is skew-symmetric; C qd are torques, N m."""
        result: Array = self.calls["coriolis_matrix"](q, qd, out=out, threads=threads)
        return result

    def gravity(self, q: ArrayLike, *, out: Array | None = None, threads: int = 1) -> Array:
        """Torques that hold the arm at rest: (..., n) N m."""
        result: Array = self.calls["gravity"](q, out=out, threads=threads)
        return result


def _kernel(arm: Arm, name: str, *options: tuple[str, Any]) -> Kernel:
    return make_kernel(name, arm.model, dict(options))
