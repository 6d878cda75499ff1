"""The compiled program: frozen data that the virtual machine reads and nobody changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from holonom.lang.diagnostics import Diagnostic
from holonom.lang.machine import Array

__all__ = ["Global", "Op", "Operand", "Program", "Routine", "Value"]

Value = float | str | Array
Operand = int | float | str | Array | tuple[str, int] | tuple[str | None, ...] | None


class Op(NamedTuple):
    """One operation of the stack machine: what it is, its operand, and the source line it comes from."""

    code: str
    operand: Operand
    line: int


@dataclass(frozen=True, slots=True)
class Global:
    """A variable that lives as long as the program, with the values a location file gave it.

    `given` holds (indices, value) pairs; the indices are empty for a variable that is no array.
    """

    name: str
    given: tuple[tuple[tuple[int, ...], Array], ...] = ()


@dataclass(frozen=True, slots=True)
class Routine:
    """One `.PROGRAM`: its code, and the names of its own variables, the parameters first."""

    name: str
    parameters: int
    variables: tuple[str, ...]
    code: tuple[Op, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """A compiled file. The first routine is the one that runs.

    Attributes
    ----------
    file : str
        Name of the source file.
    lines : tuple of str
        Its lines, for messages and listings.
    routines : tuple of Routine
        In the order of the file.
    globals : tuple of Global
        Variables shared by all routines.
    warnings : tuple of Diagnostic
        Findings that do not stop the program from running.
    """

    file: str
    lines: tuple[str, ...]
    routines: tuple[Routine, ...]
    globals: tuple[Global, ...]
    warnings: tuple[Diagnostic, ...]

    def source(self, line: int) -> str:
        """Return a source line, counted from 1."""
        return self.lines[line - 1]
