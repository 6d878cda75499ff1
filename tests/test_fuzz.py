"""The fuzzer finds what it is for; a few inputs of every reader. `make fuzz` reads a hundred thousand of each."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from fuzz.mutate import mutant  # noqa: E402
from fuzz.readers import READERS, SEEDS  # noqa: E402

FAULTY = """
import sys
sys.path.insert(0, {root!r})
from pathlib import Path
from fuzz import run
from fuzz.readers import Reader
from holonom.errors import LogError

run.FOUND = Path({found!r})

def read(path):
    kind = len(path.read_bytes()) % 5
    if kind == 0:
        {{}}["key"]
    elif kind == 1:
        while True:
            pass
    elif kind == 2:
        bytearray(2**31)
    elif kind == 3:
        import warnings
        warnings.warn("overflow", RuntimeWarning)
    else:
        raise LogError("named")

sys.exit(run.run_reader("locations", Reader(read, ".loc"), range(40)))
"""


def test_whatever_is_no_named_error_is_found_and_kept(tmp_path: Path) -> None:
    """A key that is not there, a loop, two gigabytes, a warning: a failure each; a named error is none."""
    code = FAULTY.format(root=str(ROOT), found=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 4, done.stderr
    for kind in ("KeyError", "Slow", "MemoryError", "RuntimeWarning"):
        (name,) = re.findall(rf"{kind}.*input in (\S+)", done.stdout)
        assert Path(name).is_file()


def test_an_input_is_told_by_its_number() -> None:
    seeds = [b"a = 1\nb = [2, 3]\n", b"x"]
    made = [mutant(seeds, [b"w"], f"0:cell:{k}") for k in range(300)]
    assert made == [mutant(seeds, [b"w"], f"0:cell:{k}") for k in range(300)]
    assert len(set(made)) > 200
    assert made != [mutant(seeds, [b"w"], f"1:cell:{k}") for k in range(300)]


def test_every_reader_has_seeds_that_it_reads(tmp_path: Path) -> None:
    """Else all that comes of them is refused at the same place."""
    for name, reader in READERS.items():
        for seed in (SEEDS / name).iterdir():
            if name in ("cell", "xacro"):
                continue  # cells name files beside them; xacro is a library of its own
            path = tmp_path / f"input{reader.ending}"
            path.write_bytes(seed.read_bytes() if reader.pack is None else reader.pack(seed.read_bytes()))
            reader.read(path)


def test_a_few_inputs_of_every_reader() -> None:
    quick = [name for name in READERS if name != "xacro"]
    for words in ([*quick, "--count", "40", "--seed", "7"], ["xacro", "--count", "2"]):
        command = [sys.executable, ROOT / "fuzz" / "run.py", *words]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr[-2000:]
    assert len(re.findall(r"^\w+ +\d+ inputs", done.stdout, re.MULTILINE)) == 1
