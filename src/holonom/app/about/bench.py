"""`holonom bench`: run the repository's benchmarks and print each figure beside its peer's.

A benchmark is a file of the folder `benchmarks` with a function `measure(setting) -> list[Figure]`; everything in
it runs in this process, ours and the peer in turn, compiled code warmed up.
"""

from __future__ import annotations

import importlib.util
import json
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.console.printable import say
from holonom.errors import InputError, UnknownName

__all__ = ["Figure", "Setting", "run_benchmarks", "seconds"]


@dataclass(frozen=True, slots=True)
class Setting:
    """How to measure: the random inputs, and whether only to show that everything runs."""

    rng: np.random.Generator
    small: bool


@dataclass(frozen=True, slots=True)
class Figure:
    """One measured figure: ours in `unit`, the peer's if there is one here, and what is aimed at.

    `goal` is a factor over the peer if `peer_name` is given ("at least 20 times"), else a bound on `ours` in
    `unit`; where `more_is_better` the bound is a lower one.
    """

    what: str
    ours: float
    unit: str
    peer_name: str = ""
    peer: float | None = None
    goal: float | None = None
    more_is_better: bool = False

    @property
    def ratio(self) -> float | None:
        """How many times faster than the peer."""
        if self.peer is None:
            return None
        return self.ours / self.peer if self.more_is_better else self.peer / self.ours


def seconds(function: Callable[[], object], setting: Setting, *, calls: int = 1, rounds: int = 25) -> float:
    """Median time of one call, s, over rounds of `calls` calls; one round goes before and is not counted."""
    if setting.small:
        calls, rounds = min(calls, 10), 2
    times = []
    for _ in range(rounds + 1):
        begin = time.perf_counter()
        for _ in range(calls):
            function()
        times.append((time.perf_counter() - begin) / calls)
    return statistics.median(times[1:])


def run_benchmarks(
    names: Sequence[str], *, output: Path | None = None, seed: int = 0, small: bool = False, quiet: bool = True
) -> Answer:
    """Run benchmarks by name (all unless given) and return the table.

    Raises
    ------
    UnknownName
        No such benchmark.
    InputError
        This installation has no folder of benchmarks.
    """
    files = _files()
    for name in names:
        if name not in files:
            raise UnknownName("benchmark", name, files)
    folder = prepare_output(output) if output is not None else None
    setting = Setting(np.random.default_rng(seed), small)
    figures: list[Figure] = []
    for name in names or files:
        if not quiet:
            say(f"{name} ...", error=True)
        figures += _load(files[name]).measure(setting)
    data = {"figures": [asdict(f) | {"ratio": f.ratio} for f in figures], "small": small}
    if folder is not None:
        (folder / "bench.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    return Answer(_table(figures), data)


def _files() -> dict[str, Path]:
    for folder in (Path.cwd() / "benchmarks", Path(__file__).parents[4] / "benchmarks"):
        found = {p.stem: p for p in sorted(folder.glob("bench_*.py"))}
        if found:
            return {name.removeprefix("bench_"): path for name, path in found.items()}
    raise InputError("no folder 'benchmarks' here; benchmarks come with the repository: run this in a clone of it")


def _load(path: Path) -> ModuleType:
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _table(figures: Sequence[Figure]) -> str:
    rows = [("what", "ours", "peer", "", "ratio", "goal")]
    rows += [(f.what, _quantity(f.ours, f.unit), *_peer(f), _goal(f)) for f in figures]
    widths = [max(len(row[k]) for row in rows) for k in range(6)]
    lines = []
    for row in rows:
        cells = [row[0].ljust(widths[0]), row[1].rjust(widths[1]), row[2].rjust(widths[2]), row[3].ljust(widths[3])]
        lines.append("  ".join([*cells, row[4].rjust(widths[4]), row[5].ljust(widths[5])]).rstrip())
    return "\n".join(lines)


def _quantity(value: float, unit: str) -> str:
    return f"{value:,.3g} {unit}" if abs(value) < 100 else f"{value:,.0f} {unit}"


def _peer(f: Figure) -> tuple[str, str, str]:
    if not f.peer_name:
        return "", "", ""
    if f.peer is None:
        return "", f"{f.peer_name} is not installed", ""
    return _quantity(f.peer, f.unit), f.peer_name, f"{f.ratio:.1f}"


def _goal(f: Figure) -> str:
    if f.goal is None:
        return ""
    value: Any = f.ratio if f.peer_name else f.ours
    if value is None:
        return ""
    least = bool(f.peer_name) or f.more_is_better
    met = value >= f.goal if least else value <= f.goal
    bound = f"{f.goal:g} times" if f.peer_name else _quantity(f.goal, f.unit)
    return f"{'at least' if least else 'at most'} {bound}: {'met' if met else 'MISSED'}"
