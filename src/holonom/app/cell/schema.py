"""The JSON Schema of cell files: that of `Cell`, and of the short forms."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.drives import ArmLimits, BaseParts, WheelDrive
from holonom.app.cell.model.robot import GripperTool
from holonom.app.cell.model.sources import BodyTable, base_schema
from holonom.mobile.methods import ARRANGEMENTS
from holonom.model import PRESETS

__all__ = ["cell_schema"]

_SHORT_MODELS = (GripperTool, ArmLimits, WheelDrive, BaseParts)
_GYRO = {
    "noise": "standard deviation of one sample of the turning rate",
    "bias": "what it shows at rest",
    "acceleration_noise": "standard deviation of one sample of the acceleration",
}


def cell_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of cell files; `holonom doctor --schema` prints it."""
    schema = Cell.model_json_schema()
    defs, own = schema["$defs"], schema["properties"]
    robot = defs["Robot"]["properties"]
    for model in _SHORT_MODELS:
        found = model.model_json_schema()
        defs |= found.pop("$defs", {})
        defs[model.__name__] = found
    body = BodyTable.model_json_schema()["properties"]
    defs["ArmTable"] = _arm(robot)
    defs["GyroTable"] = _table("The gyro and the accelerometers.", {k: _text(v) for k, v in _GYRO.items()})
    defs["TableTable"] = _table("The work surface.", _but(defs["SurfaceTable"]["properties"], ("name",)))
    keys = set(body)
    for name in ARRANGEMENTS:
        keys |= set(base_schema(name, body)["properties"])
        robot |= {k: v for k, v in base_schema(name, body)["properties"].items() if k not in robot}
    robot["arrangement"] = _names("how the wheels stand", ARRANGEMENTS)
    defs["BaseTable"] = _table(
        "The base and its wheels; x forwards, y to the left.", {k: robot[k] for k in sorted(keys)}
    )
    defs["Robot"]["required"] = []
    defs["FloorTable"]["properties"]["patches"] = {
        "type": "array", "items": {"$ref": "#/$defs/Patch"}, "description": "ice, oil, carpet"
    }  # fmt: skip
    own |= _short()
    schema["required"] = ["cell"]
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Holonom cell file"}


def _short() -> dict[str, Any]:
    tables = {
        "arm": ("ArmTable", "one arm"),
        "gripper": ("GripperTool", "the gripper on its flange"),
        "table": ("TableTable", "the first surface"),
        "program": ("ProgramTable", "its program"),
        "limits": ("ArmLimits", "what the cell allows it"),
        "base": ("BaseTable", "one mobile base"),
        "drive": ("WheelDrive", "motor, gear and encoder of each of its wheels"),
        "steering": ("SteeringTable", "the motors that steer its wheels"),
        "gyro": ("GyroTable", "its gyro and accelerometers"),
        "control": ("BaseParts", "what its controller does about slip and dead motors"),
        "path": ("PathTable", "where it drives"),
    }
    found: dict[str, Any] = {
        key: {"$ref": f"#/$defs/{name}", "description": description} for key, (name, description) in tables.items()
    }
    faults = {"type": "array", "items": {"$ref": "#/$defs/FaultTable"}, "description": "what breaks"}
    return {**found, "faults": faults}


def _arm(robot: dict[str, Any]) -> dict[str, Any]:
    keys = ("pose", "home", "controllers", "drives", "levels", "name")
    own = {key: robot[key] for key in keys}
    own |= {"preset": _names("which arm", PRESETS), "base": robot["pose"]}
    return _table("The arm and what moves it.", own)


def _table(description: str, properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "description": description, "properties": properties, "additionalProperties": False}


def _but(properties: dict[str, Any], left_out: tuple[str, ...]) -> dict[str, Any]:
    return {key: value for key, value in properties.items() if key not in left_out}


def _names(description: str, names: Iterable[str]) -> dict[str, Any]:
    return {"type": "string", "enum": list(names), "description": description}


def _text(description: str) -> dict[str, Any]:
    return {"type": "string", "description": description}
