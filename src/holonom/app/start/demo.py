"""The examples: cells with all that they need, by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from holonom.errors import InputError, UnknownName

__all__ = ["DEFAULT", "example", "examples"]

DEFAULT = "sort_coins"
_PACKAGED = Path(__file__).with_name("examples")
"""Where a wheel has them; git has them once, in the folder `examples` of the repository."""
_IN_CLONE = Path(__file__).resolve().parents[4] / "examples"


def examples() -> Mapping[str, Path]:
    """Return the cell file of each example, by its folder's name without the number.

    Raises
    ------
    InputError
        There are none: the package was installed without them.
    """
    for folder in (_PACKAGED, _IN_CLONE):
        found = {_name(cell): cell for cell in sorted(folder.glob("*/cell.toml"))}
        if found:
            return found
    raise InputError(f"no examples in {_PACKAGED}; install holonom anew, from its wheel or from a clone")


def example(name: str) -> Path:
    """Return the cell file of an example, "sort_coins" or "01_sort_coins".

    Raises
    ------
    UnknownName
        No such example; the message lists them.
    """
    found = examples()
    for known, cell in found.items():
        if name in (known, cell.parent.name):
            return cell
    raise UnknownName("example", name, found)


def _name(cell: Path) -> str:
    return cell.parent.name.lstrip("0123456789").lstrip("_")
