"""Which equations an arm has compiled, and how: one entry of the table per kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from holonom.errors import UnknownName
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, forward_dynamics, newton_euler
from holonom.mechanics.equations.vectors import Pose, Vector, matvec, transpose, tvec
from holonom.mechanics.kernels import closed_loop, dynamics, jacobian, pose
from holonom.mechanics.kernels.floating import FLOATING
from holonom.mechanics.kernels.inverse.closed_form import FAMILIES, closed_form
from holonom.mechanics.kernels.inverse.geometry import inverse_kernel
from holonom.mechanics.kernels.inverse.result import IkResult
from holonom.mechanics.kernels.movable import BY_INERTIA, check_movable
from holonom.mechanics.kernels.placement import NEEDED, Here, bodies_of, compile_here
from holonom.mechanics.kernels.regressor import regressor_kernel
from holonom.mechanics.kernels.singularities import SINGULARITIES
from holonom.model import ArmModel
from holonom.trace import Kernel, Number

__all__ = ["KERNELS", "OPTIONS", "Calls", "frame_of", "make_kernel", "named"]

Options = Mapping[str, Any]
Builder = Callable[[ArmModel, Options], Kernel]


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

    def equation(here: Here, q: Vector) -> list[Number]:
        return kinematics.pose(here.model, q, joint, offset)

    return compile_here(model, options, equation, {"q": len(model.independent)}, {"T": (4, 4)}, name=f"fk_{name}")


def _all_frames(model: ArmModel, options: Options) -> Kernel:
    def equation(here: Here, q: Vector) -> list[Number]:
        return [v for T in kinematics.frames(here.model, q) for v in kinematics.flat_pose(T)]

    n, count = len(model.independent), len(model.joints) + 2
    return compile_here(model, options, equation, {"q": n}, {"T": (count, 4, 4)}, name="frames")


def _jacobian(model: ArmModel, options: Options) -> Kernel:
    """Of one frame, or of several: `of` is a name, or a tuple of names."""
    n, frame, of = len(model.independent), jacobian.frame_named(options, own=True), options["of"]
    places = [frame_of(model, name) for name in ((of,) if isinstance(of, str) else of)]

    def equation(here: Here, q: Vector) -> list[Number]:
        return [entry for place in places for entry in kinematics.jacobian(here.model, q, frame, *place)]

    shape = (6, n) if isinstance(of, str) else (len(of), 6, n)
    which = "" if of == "tool" else f"_{of if isinstance(of, str) else '_'.join(of)}"
    return compile_here(model, options, equation, {"q": n}, {"J": shape}, name=f"jacobian_{frame}{which}")


def _joint_torques(model: ArmModel, options: Options) -> Kernel:
    """J^T h."""
    n, frame = len(model.independent), jacobian.frame_named(options)

    def equation(here: Here, q: Vector, wrench: Vector) -> list[Number]:
        J = kinematics.jacobian(here.model, q, frame)
        return matvec(transpose([J[n * i : n * i + n] for i in range(6)]), wrench)

    return compile_here(model, options, equation, {"q": n, "wrench": 6}, {"tau": n}, name=f"joint_torques_{frame}")


def _dynamics(verb: str, equation: Callable[..., list[Number]], given: str, wanted: str) -> Builder:
    """Builder of a dynamics kernel: q, qd, what is given and perhaps a wrench make what is wanted."""

    def build(model: ArmModel, options: Options) -> Kernel:
        n, _ = len(model.independent), bodies_of(model)
        friction, frame = options["friction"], options["wrench_frame"]
        if frame not in (None, "world", "tool"):
            raise UnknownName("wrench frame", str(frame), ("world", "tool"))

        def traced(here: Here, q: Vector, qd: Vector, x: Vector, wrench: Vector | None = None) -> list[Number]:
            load = None if wrench is None else _wrench_in_tool(here.model, q, wrench, frame)
            return equation(here.model, here.bodies, q, qd, x, friction=friction, wrench_tool=load)

        inputs = {"q": n, "qd": n, given: n} | ({"wrench": 6} if frame else {})
        checked = verb in BY_INERTIA  # stretched out, an arm of point masses has a singular inertia
        return compile_here(model, options, traced, inputs, {wanted: n}, name=verb, checked=checked)

    return build


def _mass_matrix(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)

    def equation(here: Here, q: Vector) -> list[Number]:
        return [v for row in composite_body.mass_matrix(here.model, here.bodies, q) for v in row]

    return compile_here(model, options, equation, {"q": n}, {"B": (n, n)}, name="mass_matrix")


def _gravity(model: ArmModel, options: Options) -> Kernel:
    n = len(model.independent)
    rest = [0.0] * n

    def equation(here: Here, q: Vector) -> list[Number]:
        return newton_euler.inverse_dynamics(here.model, here.bodies, q, rest, rest)

    return compile_here(model, options, equation, {"q": n}, {"g": n}, name="gravity")


def _inverse_geometry(model: ArmModel, options: Options) -> Kernel:
    form = closed_form(model)
    if form is None:
        raise UnknownName("closed-form inverse for arm", model.name, FAMILIES)
    return inverse_kernel(model, form, lambda q, status: IkResult(q, status, form.names))


KERNELS: Mapping[str, Builder] = {
    "closed_loop": closed_loop.closed_loop_kernel,
    "stiction": closed_loop.stiction_kernel,
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
    **dynamics.DYNAMICS,
    **FLOATING,
    **jacobian.JACOBIANS,
    **SINGULARITIES,
    "pose_task": pose.task,
    "criterion": pose.criterion,
}

_LOADED: Options = {"friction": None, "wrench_frame": None}
OPTIONS: Mapping[str, Options] = {
    "fk": {"frame": "tool"},
    "jacobian": {"frame": "world", "of": "tool"},
    **{name: {"frame": "world"} for name in ("joint_torques", *jacobian.FRAMED)},
    "analytic_jacobian": {"angles": None},
    "floating_inverse": {"friction": None},
    "floating_forward": {"friction": None},
    "manipulability": {"part": "all"},
    "inverse_dynamics": _LOADED,
    "forward_dynamics": _LOADED,
    **{name: {"friction": None} for name in dynamics.WITH_FRICTION},
}
"""Options of the kernels that have any, and what they are by default; friction None: where the model states some."""


class Calls(dict[Any, Callable[..., Any]]):
    """The calls of an arm's kernels, made when first asked for: `calls["gravity"]`, `calls["fk", "tool"]`.

    Options follow the name in the order of `OPTIONS`: a look-up of a tenth of a microsecond, where keywords take one.
    `make(key)` makes one.
    """

    def __init__(self, make: Callable[[Any], Callable[..., Any]]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, key: Any) -> Callable[..., Any]:
        call = self[key] = self._make(key)
        return call


def named(key: Any) -> tuple[str, dict[str, Any]]:
    """Name and options of a kernel from a key of `Calls`."""
    name, *values = (key,) if isinstance(key, str) else key
    return name, dict(zip(OPTIONS[name], values, strict=True)) if values else {}


def make_kernel(name: str, model: ArmModel, options: Options) -> Kernel:
    """Trace and wrap the equation `name` of the table for one arm.

    Raises
    ------
    UnknownName
        No such equation.
    MissingInertia
        It needs masses that the arm does not state.
    """
    if name not in KERNELS:
        raise UnknownName("kernel", name, KERNELS)
    loaded = options.get("given") == NEEDED or "payload" in (*options.get("given", ()), *options.get("varied", ()))
    if name in BY_INERTIA and not loaded:  # else what moves is known when it is called
        check_movable(model)
    return KERNELS[name](model, options)
