"""Tables of a file for `holonom tune`: plain numbers in SI, or quantities in text; faults with file, line and key."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from holonom.app.fields.toml_faults import line_of, written_key
from holonom.app.fields.toml_lines import key_lines
from holonom.app.fields.units import DIMENSIONS, parse_quantity
from holonom.errors import InputError, ModelError, UnknownName
from holonom.registry import Field, check_value

__all__ = ["TuningFile"]


@dataclass(frozen=True, slots=True)
class TuningFile:
    """A file, its text, and what it holds."""

    path: Path
    text: str
    data: Mapping[str, Any]

    def place(self, *keys: str) -> str:
        """Return `file:line: key`."""
        return f"{self.path}:{line_of(keys, key_lines(self.text))}: {written_key(keys)}"

    def only(self, names: Iterable[str]) -> None:
        """Refuse a table that is none of these.

        Raises
        ------
        ModelError
        """
        known = tuple(names)
        for name in self.data:
            if name not in known:
                raise ModelError(f"{self.place(name)}: {UnknownName('table', name, known)}")

    def table(self, name: str) -> dict[str, Any]:
        """Return a table, empty where there is none.

        Raises
        ------
        ModelError
            It is a value.
        """
        found = self.data.get(name, {})
        if not isinstance(found, dict):
            raise ModelError(f"{self.place(name)}: {found!r} came; a table [{name}] is expected")
        return found

    def values(self, table: str, fields: Mapping[str, Field], more: Iterable[str] = ()) -> dict[str, Any]:
        """Return the values of a table by their fields, in SI; keys of `more` are left out.

        Raises
        ------
        ModelError
            A key that is unknown or wrong.
        """
        found = {}
        for key, value in self.table(table).items():
            if key in more:
                continue
            try:
                if key not in fields:
                    raise UnknownName("key", key, [*fields, *more])
                found[key] = check_value(key, in_si(value, fields[key].parameter.unit), fields[key])
            except InputError as problem:
                raise ModelError(f"{self.place(table, key)}: {problem}") from None
        return found


def in_si(value: Any, unit: str) -> Any:
    """A value with every text in it that is a quantity of a unit's dimension as a number in SI."""
    if isinstance(value, list):
        return [in_si(each, unit) for each in value]
    written = unit.replace(" ", "")
    dimension = next((d for d, units in DIMENSIONS.items() if written and units.get(written) == 1.0), None)
    return parse_quantity(value, dimension) if isinstance(value, str) and dimension is not None else value


def gain_unit(loop: str, loops: Container[str]) -> str:
    """Unit of the gain of a loop of an axis, which has these loops."""
    angle = "A/rad" if "current" in loops else "V/rad"
    return {"current": "V/A", "speed": "A s/rad", "position": "1/s", "angle": angle}[loop]
