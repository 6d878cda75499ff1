"""What a recording lacks, and when."""

from __future__ import annotations

from dataclasses import dataclass, replace

__all__ = ["Missing"]

MOST = 3
"""Reasons that are told."""


@dataclass(frozen=True, slots=True)
class Missing:
    """A stretch of a file that could not be read.

    Attributes
    ----------
    since, until_then
        Times (s) of the last message before it and of the first one behind it; None where there is none.
    reasons
        What could not be read there, in its order.
    count
        How many messages came before it.
    rest
        Whether nothing behind it can be read.
    """

    since: float | None
    until_then: float | None
    reasons: tuple[str, ...]
    count: int
    rest: bool = False

    def more(self, reason: str, *, rest: bool = False) -> Missing:
        """The same with one more reason."""
        known = self.reasons if reason in self.reasons else (*self.reasons, reason)
        return replace(self, reasons=known, rest=self.rest or rest)

    def until(self, time: float) -> Missing:
        """The same, ending at a time, s."""
        return replace(self, until_then=time)

    def moved(self, by: float) -> Missing:
        """The same, so many seconds later."""
        since, until = (None if time is None else time + by for time in (self.since, self.until_then))
        return replace(self, since=since, until_then=until)

    def text(self) -> str:
        """In words: from when to when, and why."""
        since = "from the beginning" if self.since is None else f"from {self.since:g} s"
        until = "on" if self.until_then is None else f"to {self.until_then:g} s"
        more = f" and {len(self.reasons) - MOST} more" if len(self.reasons) > MOST else ""
        return f"{since} {until}: {', '.join(self.reasons[:MOST])}{more}"
