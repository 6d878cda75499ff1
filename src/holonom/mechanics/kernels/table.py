"""Which equations an arm has compiled, and how: one entry of the table per kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from holonom.errors import MissingInertia, UnknownName
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import closed_loop, composite_body, forward_dynamics, newton_euler
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.rotors import links_with_rotors
from holonom.mechanics.equations.vectors import Pose, Vector, matvec, transpose, tvec
from holonom.mechanics.kernels import dynamics as dynamics_kernels
from holonom.mechanics.kernels import jacobian as jacobian_kernels
from holonom.mechanics.kernels import pose as pose_kernels
from holonom.mechanics.kernels.closed_form import FAMILIES, closed_form
from holonom.mechanics.kernels.ik_result import IkResult
from holonom.mechanics.kernels.inverse_geometry import inverse_kernel
from holonom.mechanics.kernels.regressor import regressor_kernel
from holonom.mechanics.kernels.singularities import SINGULARITIES
from holonom.model import ArmModel
from holonom.trace import Kernel, Number, compile

__all__ = ["KERNELS", "OPTIONS", "Calls", "bodies_of", "frame_of", "make_kernel"]

Options = Mapping[str, Any]
Builder = Callable[[ArmModel, Options], Kernel]


def bodies_of(model: ArmModel) -> list[Inertial]:
    """Return the inertial parameters of the links.

    Raises
    ------
    MissingInertia
        The model states none.
    """
    if model.bodies is None:
        raise MissingInertia(
            f"arm {model.name!r} states no masses and inertias, so it has kinematics only; "
            "give bodies (mass, com, inertia per link; <inertial> in a URDF) for dynamics"
        )
    return links_with_rotors(model, model.bodies)


def frame_of(model: ArmModel, name: str) -> tuple[int | None, Pose | None]:
    """The joint that carries a named frame (-1: base, None: the tool's) and the frame's pose in the joint's frame.

    Raises
    ------
    UnknownName
        No such frame; lists them.
    """
    known: dict[str, tuple[int | None, Pose | None]] = {"tool": (None, None), "base": (-1, None)}
    known |= {f"link{k + 1}": (k, None) for k in range(len(model.joints))}
    known |= {frame.name: (frame.joint, kinematics.split(frame.pose)) for frame in model.frames}
    if name not in known:
        raise UnknownName("frame", name, known)
    return known[name]


def _wrench_in_tool(model: ArmModel, q: Vector, wrench: Vector, frame: str) -> list[Number]:
    if frame == "tool":
        return list(wrench)
    R, _ = kinematics.frames(model, q)[-1]
    return [*tvec(R, wrench[:3]), *tvec(R, wrench[3:])]


def _fk(model: ArmModel, options: Options) -> Kernel:
    name = options["frame"]
    joint, offset = frame_of(model, name)
    return compile(
        lambda q: kinematics.pose(model, q, joint, offset),
        {"q": len(model.independent)},
        {"T": (4, 4)},
        name=f"{model.name}_fk_{name}",
    )


def _all_frames(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)

    def equation(q: Vector) -> list[Number]:
        return [v for T in kinematics.frames(model, q) for v in kinematics.flat_pose(T)]

    count = len(model.joints) + 2
    return compile(equation, {"q": n}, {"T": (count, 4, 4)}, name=f"{model.name}_frames")


def _jacobian(model: ArmModel, options: Options) -> Kernel:
    n, frame = len(model.independent), jacobian_kernels.frame_named(options)
    return compile(
        lambda q: kinematics.jacobian(model, q, frame),
        {"q": n},
        {"J": (6, n)},
        name=f"{model.name}_jacobian_{frame}",
    )


def _joint_torques(model: ArmModel, options: Options) -> Kernel:
    """J^T h."""
    n, frame = len(model.independent), jacobian_kernels.frame_named(options)

    def equation(q: Vector, wrench: Vector) -> list[Number]:
        J = kinematics.jacobian(model, q, frame)
        return matvec(transpose([J[n * i : n * i + n] for i in range(6)]), wrench)

    return compile(equation, {"q": n, "wrench": 6}, {"tau": n}, name=f"{model.name}_joint_torques_{frame}")


def _dynamics(verb: str, equation: Callable[..., list[Number]], given: str, wanted: str) -> Builder:
    """Builder of a dynamics kernel: q, qd, what is given and perhaps a wrench make what is wanted."""

    def build(model: ArmModel, options: Options) -> Kernel:
        n, bodies = len(model.independent), bodies_of(model)
        friction, frame = options["friction"], options["wrench_frame"]
        if frame not in (None, "world", "tool"):
            raise UnknownName("wrench frame", str(frame), ("world", "tool"))

        def traced(q: Vector, qd: Vector, x: Vector, wrench: Vector | None = None) -> list[Number]:
            load = None if wrench is None else _wrench_in_tool(model, q, wrench, frame)
            return equation(model, bodies, q, qd, x, friction=friction, wrench_tool=load)

        inputs = {"q": n, "qd": n, given: n} | ({"wrench": 6} if frame else {})
        return compile(traced, inputs, {wanted: n}, name=f"{model.name}_{verb}")

    return build


def _mass_matrix(model: ArmModel, options: Options) -> Kernel:
    n, bodies = len(model.independent), bodies_of(model)

    def equation(q: Vector) -> list[Number]:
        return [v for row in composite_body.mass_matrix(model, bodies, q) for v in row]

    return compile(equation, {"q": n}, {"B": (n, n)}, name=f"{model.name}_mass_matrix")


def _gravity(model: ArmModel, options: Options) -> Kernel:
    n, bodies = len(model.independent), bodies_of(model)
    rest = [0.0] * n
    return compile(
        lambda q: newton_euler.inverse_dynamics(model, bodies, q, rest, rest),
        {"q": n},
        {"g": n},
        name=f"{model.name}_gravity",
    )


def _inverse_geometry(model: ArmModel, options: Options) -> Kernel:
    form = closed_form(model)
    if form is None:
        raise UnknownName("closed-form inverse for arm", model.name, FAMILIES)
    return inverse_kernel(model, form, lambda q, status: IkResult(q, status, form.names))


def _of_bodies(build: Callable[[ArmModel, Sequence[Inertial], Options], Kernel]) -> Callable[..., Kernel]:
    """The builder of a quantity of moving masses, given the links of the model."""
    return lambda model, options: build(model, bodies_of(model), options)


KERNELS: Mapping[str, Builder] = {
    "closed_loop": lambda model, options: closed_loop.closed_loop_kernel(model, bodies_of(model), options),
    "stiction": lambda model, options: closed_loop.stiction_kernel(model, bodies_of(model), options),
    "fk": _fk,
    "frames": _all_frames,
    "jacobian": _jacobian,
    "inverse_dynamics": _dynamics("inverse_dynamics", newton_euler.inverse_dynamics, "qdd", "tau"),
    "forward_dynamics": _dynamics("forward_dynamics", forward_dynamics.forward_dynamics, "tau", "qdd"),
    "mass_matrix": _mass_matrix,
    "gravity": _gravity,
    "joint_torques": _joint_torques,
    "regressor": regressor_kernel,
    "inverse_geometry": _inverse_geometry,
    **{name: _of_bodies(build) for name, build in dynamics_kernels.DYNAMICS.items()},
    **jacobian_kernels.JACOBIANS,
    **SINGULARITIES,
    "pose_task": pose_kernels.task,
    "criterion": pose_kernels.criterion,
}

_LOADED: Options = {"friction": None, "wrench_frame": None}
OPTIONS: Mapping[str, Options] = {
    "fk": {"frame": "tool"},
    **{name: {"frame": "world"} for name in ("jacobian", "joint_torques", *jacobian_kernels.FRAMED)},
    "analytic_jacobian": {"angles": None},
    "manipulability": {"part": "all"},
    "inverse_dynamics": _LOADED,
    "forward_dynamics": _LOADED,
    **{name: {"friction": None} for name in dynamics_kernels.WITH_FRICTION},
}
"""Options of the kernels that have any, and what they are by default; friction None: where the model states some."""


class Calls(dict[Any, Callable[..., Any]]):
    """The calls of an arm's kernels, made when first asked for: `calls["gravity"]`, `calls["fk", "tool"]`.

    Options follow the name in the order of `OPTIONS`: a look-up of a tenth of a microsecond, where keywords take one.
    """

    def __init__(self, kernel: Callable[..., Kernel]) -> None:
        super().__init__()
        self._kernel = kernel

    def __missing__(self, key: Any) -> Callable[..., Any]:
        name, *values = (key,) if isinstance(key, str) else key
        call = self[key] = self._kernel(name, **dict(zip(OPTIONS[name], values, strict=True) if values else ())).call
        return call


def make_kernel(name: str, model: ArmModel, options: Options) -> Kernel:
    """Trace and wrap the equation `name` of the table for one arm."""
    if name not in KERNELS:
        raise UnknownName("kernel", name, KERNELS)
    return KERNELS[name](model, options)
