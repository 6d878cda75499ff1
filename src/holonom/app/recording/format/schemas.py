"""The texts that describe a message type in a recording: the type's own and those it needs."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files

__all__ = ["schema_text"]

_SEPARATOR = "=" * 80
_FIELD_TYPE = re.compile(r"^\s*([a-zA-Z0-9_/]+)(?:\[[^\]]*\])?\s+", re.MULTILINE)
_PRIMITIVES = {"bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16", "int32"}
_PRIMITIVES |= {"uint32", "int64", "uint64", "string"}


@cache
def schema_text(name: str) -> str:
    """Text of a ROS 2 message type with all it depends on, as rosbag2 joins them.

    Parameters
    ----------
    name
        Package and type, `"sensor_msgs/JointState"`.

    Returns
    -------
    str
        The definition, then each dependency once, after a line of 80 `=` and a line `MSG: package/Type`.
    """
    return _with_dependencies(name, set())


def _with_dependencies(name: str, seen: set[str]) -> str:
    text = _definition(name)
    for dependency in _dependencies(text, name.partition("/")[0]):
        if dependency not in seen:
            seen.add(dependency)
            text += f"\n{_SEPARATOR}\nMSG: {dependency}\n{_with_dependencies(dependency, seen)}"
    return text


def _definition(name: str) -> str:
    package, _, kind = name.partition("/")
    return (files(__package__) / "definitions" / package / f"{kind}.msg").read_text(encoding="utf-8")


def _dependencies(text: str, package: str) -> list[str]:
    types = set(_FIELD_TYPE.findall(text)) - _PRIMITIVES
    return sorted(t if "/" in t else f"{package}/{t}" for t in types)
