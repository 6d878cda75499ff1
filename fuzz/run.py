"""`make fuzz`: reads mutants of seeds; whatever is no named error, takes over a second or a gigabyte, is written down.

The inputs of a run are told by `--seed` and their numbers alone: what was found once is found again.
"""

from __future__ import annotations

import argparse
import gc
import resource
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType

sys.path.insert(0, str(Path(__file__).parents[1]))

from fuzz.mutate import mutant
from fuzz.readers import READERS, SEEDS, Reader
from holonom.errors import InputError, ModelWarning

__all__ = ["main", "run_reader"]

LONGEST = 1.0
"""s of the processor for an input."""
MEMORY = 2**30
"""Bytes that an input may take."""
FOUND = Path(__file__).parent / "found"
"""Where inputs go that a reader failed at."""


class Slow(BaseException):
    """An input took longer than `LONGEST`; no reader catches it."""


def main(words: Sequence[str] | None = None) -> int:
    """Run the readers that are asked for; 1 where one failed."""
    parser = argparse.ArgumentParser(prog="fuzz", description=__doc__)
    parser.add_argument("readers", nargs="*", metavar="READER", help=f"of {', '.join(READERS)}; all unless given")
    parser.add_argument("--count", type=int, help="inputs of each; 100000 unless given, 1000 of xacro")
    parser.add_argument("--seconds", type=float, help="stop after so many, shared by all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    given = parser.parse_args(words)
    names = given.readers or list(READERS)
    if unknown := sorted(set(names) - set(READERS)):
        parser.error(f"no reader {', '.join(unknown)}; there is {', '.join(READERS)}")
    failed = 0
    for name in names:
        count = given.count if given.count is not None else READERS[name].count
        share = given.seconds / len(names) if given.seconds is not None else float("inf")
        failed += run_reader(name, READERS[name], range(given.first, given.first + count), share, given.seed)
    return int(failed > 0)


def run_reader(name: str, reader: Reader, numbers: Sequence[int], seconds: float = float("inf"), seed: int = 0) -> int:
    """Let a reader read inputs by their numbers, for so long at most; return at how many it failed."""
    seeds = [path.read_bytes() for path in sorted((SEEDS / name).iterdir())]
    words = [word.encode() for word in reader.words.split(" ")]
    signal.signal(signal.SIGPROF, _too_slow)
    refused = read = 0
    found: dict[str, Path] = {}
    begin = time.perf_counter()
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        path = Path(folder) / f"input{reader.ending}"
        path.write_bytes(seeds[0] if reader.pack is None else reader.pack(seeds[0]))
        with suppress(Exception):
            reader.read(path)  # whatever is loaded and compiled at first is none of an input's
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ModelWarning)  # what a robot file states beside itself
        _limit_memory()
        for number in numbers:
            if time.perf_counter() - begin > seconds:
                break
            data = mutant(seeds, words, f"{seed}:{name}:{number}")
            try:
                _read(reader, path, data)
            except InputError:
                refused += 1
            except (Exception, Slow) as error:
                _write_down(found, name, reader, f"{seed}-{number}", data, error)
            read += 1
    pace = read / max(time.perf_counter() - begin, 1e-9)
    print(f"{name:12} {read:8} inputs, {refused:8} refused, {len(found):3} kinds of failure, {pace:6.0f}/s", flush=True)
    return len(found)


def _read(reader: Reader, path: Path, data: bytes) -> None:
    path.write_bytes(data if reader.pack is None else reader.pack(data))
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        reader.read(path)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def _write_down(
    found: dict[str, Path], name: str, reader: Reader, number: str, data: bytes, error: BaseException
) -> None:
    """Keep an input, the first of those that end at one place; its number is that of the run's seed, and its own."""
    places = [frame for frame in traceback.extract_tb(error.__traceback__) if "holonom" in frame.filename]
    place = f"{type(error).__name__} at {Path(places[-1].filename).name}:{places[-1].lineno}" if places else repr(error)
    if place not in found:
        FOUND.mkdir(exist_ok=True)
        found[place] = FOUND / f"{name}-{number}{reader.ending}"
        found[place].write_bytes(data if reader.pack is None else reader.pack(data))
        print(f"{name} {number}: {place}: {str(error)[:200]!r}; input in {found[place]}", flush=True)


def _limit_memory() -> None:
    gc.collect()
    used = int(Path("/proc/self/statm").read_text("ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _too_slow(number: int, frame: FrameType | None) -> None:
    raise Slow(f"longer than {LONGEST:g} s")


if __name__ == "__main__":
    sys.exit(main())
