"""The cell of one base as the old base assembly takes it; `holonom.app.cell` reads every cell."""

from __future__ import annotations

from pathlib import Path

from holonom.app.base.cell_model import BaseCell
from holonom.app.toml_faults import parse_toml
from holonom.errors import CellError

__all__ = ["load_cell"]


def load_cell(path: str | Path) -> BaseCell:
    """Read the cell file of a base.

    Raises
    ------
    CellError
        No TOML.
    ValidationError
        What pydantic finds wrong.
    """
    path = Path(path)
    data = parse_toml(path, path.read_text("utf-8"), CellError)
    return BaseCell.model_validate(data, context={"folder": path.parent})
