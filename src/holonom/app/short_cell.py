"""Reading a cell file: TOML to a checked `Cell`, or one error that names file, line and key of all that is wrong."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from holonom.app.arm.cell_model import ArmCell
from holonom.app.base.cell_model import BaseCell
from holonom.app.toml_faults import parse_toml, worded_faults
from holonom.errors import CellError

__all__ = ["ArmCell", "BaseCell", "cell_schema", "load_cell"]

KINDS: dict[str, type[ArmCell] | type[BaseCell]] = {"arm": ArmCell, "base": BaseCell}
"""What a cell is of, by the table that every cell file has one of."""


def load_cell(path: str | Path) -> ArmCell | BaseCell:
    """Read and check a cell file.

    Parameters
    ----------
    path : the TOML file; the files that it names are relative to its folder.

    Returns
    -------
    The cell, in SI units and radians, with files as paths that exist.

    Raises
    ------
    CellError
        One line for each fault: file, line, key, what came, what is expected.
    """
    path = Path(path)
    text = _read(path)
    data = parse_toml(path, text, CellError)
    model = _kind(path, data)
    try:
        return model.model_validate(data, context={"folder": path.parent})
    except ValidationError as error:
        raise CellError(worded_faults(path, text, model, error.errors(include_url=False))) from None


def cell_schema() -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of cell files; `holonom doctor --schema` prints it."""
    schema = TypeAdapter(ArmCell | BaseCell).json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": "Holonom cell file"}


def _kind(path: Path, data: Mapping[str, Any]) -> type[ArmCell] | type[BaseCell]:
    named = [name for name in KINDS if name in data]
    if len(named) == 2:
        raise CellError(f"{path}:1: tables [arm] and [base] came; a cell has one of them, give the other its own file")
    return KINDS[named[0]] if named else ArmCell


def _read(path: Path) -> str:
    try:
        raw = path.read_bytes()
        return raw.decode("utf-8")
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        raise CellError(f"{path}:{line}: not UTF-8 text, so no TOML; save the file as UTF-8") from None
    except OSError as error:
        raise CellError(f"{path}: {error.strerror}; give the path of a cell file (TOML)") from None
