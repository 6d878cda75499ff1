"""The table of tables: every kind of method, and where its table lies."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from holonom.errors import UnknownName
from holonom.registry import Table, imported

__all__ = ["TABLES", "table_of"]

TABLES: Mapping[str, str] = MappingProxyType(
    {
        "commands": "holonom.app.commands:COMMANDS",
    }
)
"""Kind to the import path of its table."""


def table_of(kind: str) -> Table:
    """Return the table of a kind.

    Raises
    ------
    UnknownName
    """
    if kind not in TABLES:
        raise UnknownName("kind of method", kind, TABLES)
    found: Table = imported(TABLES[kind])
    return found
