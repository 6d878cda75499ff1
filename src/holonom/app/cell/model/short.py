"""Short forms of a cell file: `[arm]`, `[base]` and what belongs to them become the lists of `Cell`.

Every key keeps the place at which the user wrote it, for messages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from holonom.app.cell.model.robot import Robot
from holonom.app.fields.toml_lines import KeyPath
from holonom.errors import CellError

__all__ = ["SHORT", "Misplaced", "Written", "written_out"]

ROBOT: KeyPath = ("robot", 0)
_OF_ARM = {"gripper": "tool", "program": "program", "limits": "limits"}
_OF_BASE = {"drive": "drives", "steering": "steering", "control": "controllers", "path": "path"}
_BASE_KEYS = ("pose", "velocity", "hold", "start", "done", "drives", "limits", "name", "balance")
_GYRO = {"noise": (0, "noise"), "bias": (0, "bias"), "acceleration_noise": (1, "noise")}
"""Keys of [gyro]: number of the sensor and its parameter."""
SHORT = ("arm", "base", *_OF_ARM, *_OF_BASE, "table", "gyro", "faults")
"""Tables that short forms add to a cell's."""


class Misplaced(CellError):
    """A table that does not go with the others; `key` is its name."""

    def __init__(self, key: str, text: str) -> None:
        super().__init__(text)
        self.key = key


@dataclass
class Written:
    """A cell's tables as `Cell` takes them.

    `places` says where the user wrote a key, by the beginning of its path; `also` which keys a table may have as well.
    """

    data: dict[str, Any]
    places: dict[KeyPath, KeyPath] = field(default_factory=dict)
    also: dict[KeyPath, tuple[str, ...]] = field(default_factory=lambda: {(): SHORT})

    def place(self, at: KeyPath) -> KeyPath:
        """Return the path of a key as the user wrote it."""
        for k in range(len(at), 0, -1):
            if at[:k] in self.places:
                return (*self.places[at[:k]], *at[k:])
        return at


def written_out(data: Mapping[str, Any]) -> Written:
    """Return a cell file's data with its short forms written out.

    Raises
    ------
    Misplaced
        Short forms that do not go together.
    """
    found = Written(dict(data))
    _check_together(data)
    if "robot" in data:
        _robots(found)
    elif "base" in data:
        _base(found)
    elif "arm" in data or any(key in data for key in _OF_ARM):
        _arm(found)
    _move(found, "faults", ("fault",))
    _surface(found)
    _patches(found)
    return found


def _check_together(data: Mapping[str, Any]) -> None:
    robots = [key for key in ("arm", "base") if key in data]
    if len(robots) == 2:
        raise Misplaced(
            "base",
            "tables [arm] and [base] came; a cell has one of them; make each a [[robot]], or give the other a file",
        )
    if robots and "robot" in data:
        raise Misplaced(robots[0], f"tables [{robots[0]}] and [[robot]] came; make each a [[robot]]")
    of = _OF_ARM if "base" in data else _OF_BASE if "arm" in data else {}
    if "robot" in data:
        of = {**_OF_ARM, **_OF_BASE}
    for key, robot_key in of.items():
        if key in data and not ("base" in data and key == "limits"):
            owner = "[arm]" if key in _OF_ARM else "[base]"
            raise Misplaced(key, f"table [{key}] came, which belongs to {owner}; a [[robot]] says so as {robot_key!r}")


def _move(found: Written, key: str, to: KeyPath, value: Any = None) -> None:
    """Take a table of the file to its place in the lists."""
    if key in found.data:
        value = found.data.pop(key)
        if len(to) == 1:
            found.data[str(to[0])] = value
        found.places[to] = (key,)


def _robots(found: Written) -> None:
    """`arrangement` or `wheels` in a [[robot]] itself, with their keys beside."""
    tables = found.data["robot"]
    if not isinstance(tables, list):
        return
    found.data["robot"] = [
        _with_model(found, table, ("robot", number), ("robot", number)) if isinstance(table, dict) else table
        for number, table in enumerate(tables)
    ]


def _with_model(found: Written, table: Mapping[str, Any], at: KeyPath, user: KeyPath) -> dict[str, Any]:
    """Gather the keys of wheels that stand in a robot's own table into its `model`."""
    if "model" in table or not ("arrangement" in table or "wheels" in table):
        return dict(table)
    model = {key: value for key, value in table.items() if key not in Robot.model_fields}
    found.places[(*at, "model")] = user
    return {key: value for key, value in table.items() if key in Robot.model_fields} | {"model": model}


def _arm(found: Written) -> None:
    table = found.data.pop("arm", {})
    found.places[ROBOT] = ("arm",)
    if not isinstance(table, dict):
        found.data["robot"] = [table]
        return
    robot = {key: value for key, value in table.items() if key not in ("preset", "base")}
    if "preset" in table:
        robot["model"] = {"preset": table["preset"]}
        found.places[(*ROBOT, "model", "preset")] = ("arm", "preset")
        found.places[(*ROBOT, "model")] = ("arm", "preset")
    if "base" in table:
        robot["pose"] = table["base"]
        found.places[(*ROBOT, "pose")] = ("arm", "base")
    _gather(found, robot, _OF_ARM)
    found.also[ROBOT] = ("preset", "base")
    found.data["robot"] = [robot]


def _base(found: Written) -> None:
    table = found.data.pop("base")
    found.places[ROBOT] = ("base",)
    found.places[(*ROBOT, "model")] = ("base",)
    if not isinstance(table, dict):
        found.data["robot"] = [table]
        return
    robot = {key: value for key, value in table.items() if key in _BASE_KEYS}
    robot["model"] = {key: value for key, value in table.items() if key not in _BASE_KEYS}
    _gather(found, robot, {**_OF_BASE, "limits": "limits"})
    found.data["robot"] = [robot]
    _gyro(found)


def _gather(found: Written, robot: dict[str, Any], keys: Mapping[str, str]) -> None:
    for key, robot_key in keys.items():
        if key in found.data:
            robot[robot_key] = found.data.pop(key)
            found.places[(*ROBOT, robot_key)] = (key,)


def _gyro(found: Written) -> None:
    """[gyro] is two sensors; what it does not say is 0."""
    given = found.data.pop("gyro", {})
    listed = found.data.get("sensor")
    if listed is not None and not given:
        return
    sensors: list[dict[str, Any]] = [{"kind": "gyro", "noise": "0deg/s", "bias": "0deg/s"},
                                     {"kind": "accelerometer", "noise": "0m/s2"}]  # fmt: skip
    for number in (0, 1):
        found.places["sensor", number] = ("gyro",)
    if not isinstance(given, dict):
        raise Misplaced("gyro", f"{given!r} came; a table is expected")
    for key, value in given.items():
        number, name = _GYRO.get(key, (0, key))
        sensors[number][name] = value
        found.places["sensor", number, name] = ("gyro", key)
    own = listed if isinstance(listed, list) else []
    for number in range(len(own)):
        found.places["sensor", number + 2] = ("sensor", number)
    found.data["sensor"] = [*sensors, *own]


def _surface(found: Written) -> None:
    """[table] is the first surface."""
    if "table" not in found.data:
        return
    table = found.data.pop("table")
    own = found.data.get("surface", [])
    first = {"name": "table", **table} if isinstance(table, dict) else table
    found.data["surface"] = [first, *own]
    for number in range(len(own)):
        found.places["surface", number + 1] = ("surface", number)
    found.places["surface", 0] = ("table",)


def _patches(found: Written) -> None:
    """[[floor.patches]] stand before [[patch]]."""
    floor = found.data.get("floor")
    if not isinstance(floor, dict) or "patches" not in floor:
        return
    first, own = floor["patches"], found.data.get("patch", [])
    found.data["floor"] = {key: value for key, value in floor.items() if key != "patches"}
    found.places["patch",] = ("floor", "patches")
    if not isinstance(first, list):
        found.data["patch"] = first
        return
    found.data["patch"] = [*first, *own]
    for number in range(len(own)):
        found.places["patch", len(first) + number] = ("patch", number)
