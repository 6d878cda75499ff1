"""`[[robot]]`: what it is, what moves it, where it stands and what it is to do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    Strict,
    TypeAdapter,
    ValidationInfo,
    model_validator,
)
from pydantic_core import core_schema

from holonom.app.cell.model.drives import (
    ArmLimits,
    BaseLimits,
    BaseParts,
    JointDrive,
    LevelsTable,
    SteeringTable,
    WheelDrive,
)
from holonom.app.cell.model.places import Placement
from holonom.app.cell.model.refusals import Faults, read_form, refuse
from holonom.app.cell.model.sources import ArmSource, BaseSource, ReadModel, form_schema
from holonom.app.cell.model.tasks import PathTable, ProgramTable, SignalNumber, StartTable, TwistTable
from holonom.app.fields.methods import Chosen, OneMethod
from holonom.app.fields.quantities import Quantity, Section, Size
from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.control import BALANCE_LAWS, CONTROLLERS
from holonom.errors import CellError, OutOfLimits, UnknownName
from holonom.model import Joint, outside
from holonom.model.joint_values import looks_like_degrees

__all__ = ["GripperTool", "Robot", "RodTool"]

_DEGREE = DIMENSIONS["angle"]["deg"]
_ARM_ONLY = ("home", "tool", "program", "steady_tool")
_BASE_ONLY = ("steering", "balance", "path", "velocity", "start", "done")
_TASKS = ("program", "path", "velocity", "hold")


class GripperTool(Section):
    """A parallel gripper on the flange; the tool point lies between the finger tips."""

    kind: Literal["gripper"] = "gripper"
    """two parallel fingers"""
    length: Annotated[float, Quantity("length", "1mm", "2m")]
    """flange to finger tips"""
    mass: Annotated[float, Quantity("mass", "1g", "100kg")]
    """mass with its fingers"""
    opening: Annotated[float, Quantity("length", "1mm", "1m")]
    """distance of the open fingers"""
    finger: tuple[Size, Size, Size]
    """a finger's width, thickness (in the closing direction) and length"""
    close_time: Annotated[float, Quantity("time", "1ms", "10s")]
    """time from open to closed on nothing"""
    open_time: Annotated[float, Quantity("time", "1ms", "10s")]
    """time from closed to open"""


class RodTool(Section):
    """A rod on the flange, along the flange's z; the tool point is its end."""

    kind: Literal["rod"]
    """a rod"""
    length: Annotated[float, Quantity("length", "1mm", "2m")]
    """flange to its end"""
    mass: Annotated[float, Quantity("mass", "0g", "100kg")] = 0.0
    """its mass"""


@dataclass(frozen=True, slots=True)
class Read:
    """Reads a key whose form depends on what came before it in the table."""

    read: Callable[[Any, ValidationInfo], Any]
    forms: tuple[Any, ...]

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(self._known)

    def _known(self, given: Any, info: ValidationInfo) -> Any:
        """What it reads to; nothing where the model is at fault, which is told already."""
        return self.read(given, info) if "model" in info.data else None

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return {"anyOf": [form if isinstance(form, dict) else form_schema(form, handler) for form in self.forms]}


def _is_base(info: ValidationInfo) -> bool:
    return isinstance(info.data.get("model"), BaseSource)


def _drives(given: Any, info: ValidationInfo) -> Any:
    if isinstance(given, str):
        if given not in ("ideal", "from_limits"):
            raise UnknownName("way to drive", given, ("ideal", "from_limits"))
        return given
    if _is_base(info):
        return read_form(WheelDrive, given)
    if isinstance(given, Mapping):
        return (read_form(JointDrive, given),)
    if not isinstance(given, list | tuple) or not given:
        raise CellError(f'{given!r} came; "ideal", "from_limits", a table or a list of tables is expected')
    faults = Faults()
    found = [faults.call((number,), read_form, JointDrive, table) for number, table in enumerate(given)]
    faults.raise_any()
    return tuple(found)


def _limits(given: Any, info: ValidationInfo) -> Any:
    form: type[BaseLimits] | type[ArmLimits] = BaseLimits if _is_base(info) else ArmLimits
    return read_form(form, {} if given is None else given)


def _controllers(given: Any, info: ValidationInfo) -> Any:
    if _is_base(info):
        return read_form(BaseParts, {} if given is None else given)
    found = _LAWS.validate_python(("computed_torque",) if given is None else given, context=info.context)
    names = [law.name for law in found]
    if len(set(names)) < len(names):
        raise CellError(f"{', '.join(names)} came; name each controller once")
    return found


Laws = Annotated[tuple[Annotated[Chosen, OneMethod(CONTROLLERS)], ...], Field(min_length=1)]
_LAWS: TypeAdapter[tuple[Chosen, ...]] = TypeAdapter(Laws)


def _tool(given: Any, info: ValidationInfo) -> Any:
    kinds = {"gripper": GripperTool, "rod": RodTool}
    kind = given.get("kind", "gripper") if isinstance(given, Mapping) else "gripper"
    if kind not in kinds:
        raise refuse(("kind",), UnknownName("tool", str(kind), kinds), kind)
    form: type[GripperTool] | type[RodTool] = GripperTool if kind == "gripper" else RodTool
    return read_form(form, given)


def _home(given: Any, info: ValidationInfo) -> Any:
    source = info.data.get("model")
    if not isinstance(given, list | tuple):
        raise CellError(f"{given!r} came; a list in brackets is expected, a value for each joint")
    if not isinstance(source, ArmSource):
        raise CellError("it came; a base has none; give it a pose")
    joints = [source.model.joints[i] for i in source.model.independent]
    if len(given) != len(joints):
        what = "joint angles" if all(joint.turns for joint in joints) else "joint values"
        raise CellError(f"{len(given)} {what} came; {source.name} has {len(joints)} joints")
    faults = Faults()
    found = [
        faults.call((number,), parse_quantity, value, _dimension(joint))
        for number, (value, joint) in enumerate(zip(given, joints, strict=True))
    ]
    faults.raise_any()
    limits = [source.model.limits(i) for i in source.model.independent]
    for joint, bounds, value in zip(joints, limits, found, strict=True):
        if outside(value, bounds.lower, bounds.upper):
            low, high = (_written(bound, joint) for bound in (bounds.lower, bounds.upper))
            degrees = looks_like_degrees(
                found, [b.lower for b in limits], [b.upper for b in limits], [j.turns for j in joints]
            )
            hint = f"; are these degrees? write {value:g}deg" if degrees else ""
            raise OutOfLimits(f"{_written(value, joint)} came for {joint.name}; {low} to {high} is allowed{hint}")
    return tuple(found)


def _dimension(joint: Joint) -> str:
    return "angle" if joint.turns else "length"


def _written(value: float, joint: Joint) -> str:
    return f"{value / _DEGREE:g}deg" if joint.turns else f"{value:g}m"


_QUANTITIES = {"type": "array", "items": {"type": "string"}}


class Robot(Section):
    """A robot: an arm or a mobile base."""

    name: Annotated[str, Strict(), Field(pattern="^([A-Za-z][A-Za-z0-9_]*)?$")] = ""
    """what it is called: a letter, then letters, digits and _; may be left out where it is the only one"""
    model: Annotated[ArmSource | BaseSource, ReadModel()]
    """which arm or base: a preset, a .urdf or .xacro file, an arrangement of wheels, or a table of one of them"""
    drives: Annotated[
        str | WheelDrive | tuple[JointDrive, ...] | None,
        Read(_drives, ({"enum": ["ideal", "from_limits"]}, WheelDrive, JointDrive, tuple[JointDrive, ...])),
    ] = None
    """motor, gear and encoder of joints or wheels, or "ideal", or "from_limits"; what its model states unless given"""
    steering: SteeringTable | None = None
    """motors that steer wheels; usual ones, which the check says, unless given"""
    balance: Annotated[Chosen | None, OneMethod(BALANCE_LAWS)] = None
    """law of a body that balances on its axle; "lqr" unless given"""
    pose: Placement | None = None
    """where it stands, in the world or in the frame that `on` names; a base starts there; of a body that balances pitch
    is how far it leans forwards at the start"""
    on: Annotated[str, Strict(), Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\.[A-Za-z][A-Za-z0-9_]*)?$")] | None = None
    """frame of another robot on which it stands, such as "agv.top\""""
    home: Annotated[tuple[float, ...] | None, Read(_home, (_QUANTITIES,))] = None
    """joint values at which a run starts; the model's nominal or home pose, or zeros, unless given"""
    controllers: Annotated[tuple[Chosen, ...] | BaseParts, Read(_controllers, (Laws, BaseParts))] = Field(
        default=None, validate_default=True
    )
    """joint controllers; the program runs once under each, and the report compares them; of a base a table of parts"""
    tool: Annotated[GripperTool | RodTool | None, Read(_tool, (GripperTool, RodTool))] = None
    """what it carries on its flange"""
    limits: Annotated[ArmLimits | BaseLimits, Read(_limits, (ArmLimits, BaseLimits))] = Field(
        default=None, validate_default=True
    )
    """what the cell allows it"""
    levels: LevelsTable | None = None
    """periods of the levels of its controller; of a base, how often points of its path come"""
    program: ProgramTable | None = None
    """the robot program of an arm"""
    path: PathTable | None = None
    """the path that a base is to drive"""
    velocity: Annotated[tuple[TwistTable, ...], Field(min_length=1)] | None = None
    """the velocities that a base is to follow"""
    hold: Annotated[float, Quantity("time", "0ms", "1440min")] | None = None
    """how long it is to stand where it is"""
    steady_tool: bool | None = None
    """whether an arm on a base keeps its tool where it is in the world, between its motions, while the base moves"""
    start: StartTable | None = None
    """when its path or velocities begin: a time, or { signal = 5 }"""
    done: SignalNumber | None = None
    """signal that goes on at their end"""

    @model_validator(mode="after")
    def _keys_fit(self) -> Robot:
        if self.is_arm:
            self._refuse(_BASE_ONLY, "an arm has none; give it a program")
            self._check_steady()
        else:
            self._refuse(_ARM_ONLY, "a base has none; give it path, velocity or hold")
            self._refuse(("on",), "a base stands on the floor; leave `on` out")
            self._check_base_levels()
        given = [task for task in _TASKS if getattr(self, task) is not None]
        if len(given) > 1:
            raise refuse((given[1],), f"{' and '.join(given)} came; a robot has one of them")
        if self.velocity is not None and any(np.diff([step.at for step in self.velocity]) <= 0.0):
            raise refuse(("velocity",), "each step must be later than the one before")
        self._check_stance()
        return self

    def _check_stance(self) -> None:
        if self.is_arm:
            return
        balances = self.source.base.balances
        if self.balance is not None and not balances:
            raise refuse(("balance",), "it came; the body of this base does not balance; leave it out")
        pose = self.pose
        if pose is not None and (pose.position[2] or pose.roll or (pose.pitch and not balances)):
            raise refuse(("pose",), "a base stands level on the floor; z, roll and pitch are 0")

    def _check_steady(self) -> None:
        if not self.steady_tool:
            return
        if self.on is None:
            raise refuse(("steady_tool",), "it came; only an arm that a base carries (`on`) can lose its tool's place")
        if self.levels is not None:
            raise refuse(("steady_tool",), "it came beside levels; points of a slower supervisor cannot follow a base")

    def _check_base_levels(self) -> None:
        if self.levels is None:
            return
        if self.path is None:
            raise refuse(("levels",), "it came; of a base they are how often points of its path come; give it a path")
        for key in sorted(self.levels.model_fields_set - {"supervisor", "interpolation"}):
            raise refuse(("levels", key), "it came; a base's levels are supervisor and interpolation")

    def _refuse(self, keys: tuple[str, ...], why: str) -> None:
        for key in keys:
            if getattr(self, key) is not None:
                raise refuse((key,), f"it came; {why}")

    @property
    def is_arm(self) -> bool:
        """Whether it is an arm; else it is a mobile base."""
        return isinstance(self.model, ArmSource)

    @property
    def source(self) -> Any:
        """Its model: an `ArmSource` or a `BaseSource`."""
        return self.model
