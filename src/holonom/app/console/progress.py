"""`Progress`: a bar with the simulated time, and the wall time that is left where the end is known."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from holonom.app.console.printable import one_line, printable

__all__ = ["Progress"]

OFTEN = 0.1  # s of wall time between two looks


class Progress:
    """A bar on a terminal's error output; nothing elsewhere, or where it is `quiet`.

    Parameters
    ----------
    title : what runs.
    total : simulated time, s, at which it is expected to end; None: nobody knows.
    """

    def __init__(self, title: str, total: float | None, *, quiet: bool) -> None:
        self._title, self._total, self._shown = title, total, 0.0
        self._on = not quiet and sys.stderr.isatty()
        self._bar: Any = None
        self._task: Any = None

    def __enter__(self) -> Self:
        if self._on:
            from rich.console import Console
            from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeRemainingColumn
            from rich.progress import Progress as Bar

            columns = (
                SpinnerColumn(), TextColumn("{task.description}", markup=False), BarColumn(),
                TextColumn("{task.fields[at]}"), TextColumn("left"), TimeRemainingColumn(),
            )  # fmt: skip
            self._bar = Bar(*columns, console=Console(stderr=True), transient=True)
            self._bar.start()
            self._task = self._bar.add_task(one_line(self._title), total=self._total, at="")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, simulated: float) -> None:
        """Show a simulated time, s; at most ten times a second."""
        now = time.perf_counter()
        if self._bar is not None and now - self._shown > OFTEN:
            self._shown = now
            self._bar.update(self._task, completed=simulated, at=f"{simulated:.1f} s simulated")

    def saying(self, say: Callable[[str], None]) -> Callable[[str], None]:
        """Return what prints a line: above the bar where there is one, else `say`."""
        if self._bar is None:
            return say
        console = self._bar.console
        return lambda text: console.print(printable(text), markup=False, highlight=False)
