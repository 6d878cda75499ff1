"""What becomes of a doubt about a robot file: an error (strict), or a note that says what was taken."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, get_args

from holonom.errors import UnknownName
from holonom.model.urdf.elements import Element, fault, placed

__all__ = ["CHECKS", "Check", "CheckMode"]

CheckMode = Literal["warn", "strict"]
CHECKS: tuple[str, ...] = get_args(CheckMode)


class Check:
    """Collects the notes of one file.

    Raises
    ------
    UnknownName
        Neither "warn" nor "strict".
    """

    def __init__(self, mode: CheckMode) -> None:
        if mode not in CHECKS:
            raise UnknownName("way to check a robot file (check=)", str(mode), CHECKS)
        self.strict = mode == "strict"
        self._notes: dict[str, None] = {}  # in the order in which they came, each once

    @property
    def notes(self) -> tuple[str, ...]:
        """What was noted, each with file and line."""
        return tuple(self._notes)

    def doubt(self, element: Element, problem: str, taken: str, *, instead: str = "") -> None:
        """Refuse `problem`, with what to do `instead`; where that is not asked for, note it and what is `taken`."""
        if self.strict:
            raise fault(element, problem + (f"; {instead}" if instead else ""))
        self.note(element, f"{problem}: {taken}")

    def note(self, element: Element, what: str) -> None:
        """Note something that is no error."""
        self.remark(placed(element, what))

    def remark(self, note: str) -> None:
        """Note what already says where."""
        self._notes[note] = None

    def known(self, element: Element, tags: Iterable[str]) -> None:
        """Doubt children whose tags are close to one of `tags`: they would be passed over silently."""
        for child, meant in element.misspelt(tags):
            problem = f"{element.called()} has <{child.tag}>, which says nothing"
            self.doubt(child, problem, f"it is passed over; was <{meant}> meant?", instead=f"did you mean <{meant}>?")

    def one(self, element: Element, tag: str) -> Element | None:
        """The child of a tag, if there is one; a second is doubted, and the first taken."""
        found = element.all(tag)
        for more in found[1:]:
            problem = f"{element.called()} has a second <{tag}>"
            self.doubt(more, problem, "the first is taken", instead="keep one of them")
        return found[0] if found else None
