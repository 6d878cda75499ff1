"""The tables of `holonom bench drive`, as text, page and JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from pathlib import Path

from holonom.app.about.drive_bench.bases import BASES
from holonom.app.about.drive_bench.courses import COURSES, course
from holonom.app.about.drive_bench.driven import Driven, drive, laws_for
from holonom.app.about.drive_bench.growth import Growth, growths
from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.console.printable import say
from holonom.control import PATH_LAWS
from holonom.errors import UnknownName, UsageError

__all__ = ["FILE", "bench_drive"]

FILE = "drive_bench.json"
SIMULATED = 200  # runs of each cause
ASKED = 0.02  # m RMS that the best law of an arrangement is to keep
HEAD = """# 6.4 Laws and odometry, measured

Made by `holonom bench drive --markdown > docs/drive_bench.md`: one base of each arrangement (8 kg, about half a metre),
motors sized for 2 m/s and 2 m/s2, at 1 m/s and at most 1 m/s2 on a dry floor, by its own odometry and gyro with their
usual noise. How to choose a law: [path laws](path_laws.md).

## Laws

RMS / peak, mm, between where the base truly was and where it was to be at that time: the estimate's error counts as the
law's does. Bases that move sideways keep their path along and across at once. A dash: the base cannot drive there.
"""
BEST = """
The best law of each arrangement, by the largest RMS of its courses; time, and energy drawn less what
braking gave back, on the eight.
"""
GROWTH = """
## Growth of errors

Standard deviations at the end of a run, place in mm / heading in degrees, by propagation to first order; in brackets
what 200 simulated runs say, where that is more than 15 % away: where a cause has no effect of first order. Radius: 1 %
of each wheel's own. Slip: 1 % of each rim's way over a metre. Mounting: 1 degree of each wheel's own.
"""


def bench_drive(
    arrangements: Sequence[str] = (),
    *,
    laws: Sequence[str] = (),
    seed: int = 0,
    small: bool = False,
    markdown: bool = False,
    output: Path | None = None,
    quiet: bool = True,
) -> Answer:
    """Drive laws on arrangements, all unless given, and return the tables.

    Parameters
    ----------
    arrangements, laws : names; a base that moves sideways has no law to choose.
    small : only the straight course, and few simulated runs.
    markdown : as the page `docs/drive_bench.md`.

    Raises
    ------
    UnknownName
        No such arrangement or law.
    UsageError
        None of the laws is for any of the arrangements.
    """
    for kind, asked, known in (("arrangement", arrangements, BASES), ("law of a path", laws, PATH_LAWS)):
        for name in asked:
            if name not in known:
                raise UnknownName(kind, name, known)
    notes = _unfit(arrangements, laws)
    folder = prepare_output(output) if output is not None else None
    driven: list[Driven] = []
    grown: list[Growth] = []
    for name in arrangements or BASES:
        base = BASES[name]()
        if not quiet:
            say(f"{name} ...", error=True)
        for where in ("straight",) if small else tuple(COURSES):
            path = course(where, base)
            own = [law for law in laws_for(base) if not laws or law in laws]
            driven += [drive(base, name, law, where, path, seed) for law in own]
        grown += growths(base, name, runs=20 if small else SIMULATED, seed=seed)
    data = {"driven": [asdict(row) for row in driven], "growth": [asdict(row) for row in grown], "small": small}
    data["notes"] = notes
    if folder is not None:
        (folder / FILE).write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    tables = (_laws(driven), _best(driven), _growth(grown))
    if markdown:
        page = [part for lead, rows in zip((HEAD, BEST, GROWTH), tables, strict=True) for part in (lead, _page(rows))]
        return Answer("\n".join(page), data)
    told = [f"note: {note}" for note in notes]
    return Answer("\n\n".join([*(_plain(rows) for rows in tables if len(rows) > 1), *told]), data)


def _unfit(arrangements: Sequence[str], laws: Sequence[str]) -> list[str]:
    """Which laws that were asked for are not for which arrangements; nothing where none was asked for."""
    if not laws:
        return []
    names = tuple(arrangements or BASES)
    unfit = [name for name in names if not set(laws) & set(laws_for(BASES[name]()))]
    if not unfit:
        return []
    text = (
        f"{', '.join(laws)}: not for {', '.join(unfit)}, which move sideways and keep a path along and across at once; "
        "there is no law to choose"
    )
    if len(unfit) == len(names):
        raise UsageError(f"--laws {text}: leave --laws out, or name arrangements that do not move sideways")
    return [text]


def _laws(driven: Iterable[Driven]) -> list[list[str]]:
    return [["arrangement", "law", *COURSES], *_by_law(driven, _errors)]


def _by_law(driven: Iterable[Driven], shown: Callable[[Driven], str]) -> list[list[str]]:
    """A row per arrangement and law, a column per course."""
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for row in driven:
        rows.setdefault((row.arrangement, row.law), {})[row.course] = shown(row)
    return [[*key, *(cells.get(name, "") for name in COURSES)] for key, cells in rows.items()]


def _errors(row: Driven) -> str:
    return "-" if row.failed else f"{1e3 * row.rms:.1f} / {1e3 * row.peak:.1f}"


def _best(driven: Iterable[Driven]) -> list[list[str]]:
    """The best law of each arrangement: that whose largest RMS is least."""
    found: dict[str, dict[str, list[Driven]]] = {}
    for row in driven:
        if not row.failed:
            found.setdefault(row.arrangement, {}).setdefault(row.law, []).append(row)
    rows = [["arrangement", "best law", "largest RMS, mm", f"below {1e3 * ASKED:g} mm", "time, s", "energy, J"]]
    for arrangement, laws in found.items():
        most = max(len(runs) for runs in laws.values())
        whole = {law: max(run.rms for run in runs) for law, runs in laws.items() if len(runs) == most}
        law = min(whole, key=lambda name: whole[name])
        run = next((run for run in laws[law] if run.course == "eight"), laws[law][0])
        met = "yes" if whole[law] < ASKED else "no"
        rows.append([arrangement, law, f"{1e3 * whole[law]:.1f}", met, f"{run.time:.1f}", f"{run.effort:.1f}"])
    return rows


def _growth(grown: Iterable[Growth]) -> list[list[str]]:
    rows: dict[tuple[str, str], dict[str, str]] = {}
    for g in grown:
        rows.setdefault((g.arrangement, g.run), {})[g.cause] = _told(g)
    causes = list(dict.fromkeys(cause for cells in rows.values() for cause in cells))
    return [["arrangement", "run", *causes], *([*key, *cells.values()] for key, cells in rows.items())]


def _told(g: Growth) -> str:
    place, turn = 1e3 * g.place, math.degrees(g.heading)
    seen_place, seen_turn = 1e3 * g.simulated_place, math.degrees(g.simulated_heading)
    text = f"{place:.1f} / {turn:.2f}"
    if _agree(place, seen_place, 0.1) and _agree(turn, seen_turn, 0.01):
        return text
    return f"{text} ({seen_place:.1f} / {seen_turn:.2f})"


def _agree(a: float, b: float, least: float) -> bool:
    return abs(a - b) <= max(0.15 * max(a, b), least)


def _page(rows: Sequence[Sequence[str]]) -> str:
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def _plain(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )
