"""The kernel cache: nothing in it is older than a line that it is made of, and nothing is made twice."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import pytest

from holonom.errors import OutputError
from holonom.trace import cache_use, empty_cache
from holonom.trace.code import cache
from holonom.trace.code.cache import Entry

SOURCE = Path(cache.__file__).parents[2]
CHAIN = {
    "chain/__init__.py": "from .far import far as helper\n",
    "chain/far.py": (
        "from holonom.trace.code.loops import loop\nFACTOR = 2.0\n@loop\ndef far(x):\n    return FACTOR * x\n"
    ),
    "control/near.py": (
        "from holonom.chain import helper\nfrom holonom.control.servo.kernels import PositionParams, position_step\n"
        "from holonom.trace.code.loops import loop\n\n\n@loop\ndef near(x):\n    return helper(x) + 1.0\n\n\n"
        "@loop\ndef step(x):\n    return position_step(PositionParams(1.0, 1e9, 1.0), x, 0.0, 0.0)\n"
    ),
    "chain/top.py": (
        "from holonom.control.near import near, step\nfrom holonom.trace.code.loops import loop\n\n\n"
        "@loop\ndef top(x):\n    return near(x)\n\n\n@loop\ndef stepped(x):\n    return step(x)\n"
    ),
}
TOP = "from holonom.chain.top import top\nprint(top(10.0))"


class Ran(NamedTuple):
    out: str
    err: str
    kernels: Counter[str]
    """How many were compiled, and how many loaded."""


class Copy:
    """A copy of the package, with a chain of three files in it, and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.package, self.cache = folder, folder / "src" / "holonom", folder / "cache"
        self._log = folder / "log"

    def start(self, code: str, **more: str) -> subprocess.Popen[str]:
        environment = os.environ | {"PYTHONPATH": str(self.package.parent), "HOLONOM_CACHE": str(self.cache)}
        environment |= {"HOLONOM_CACHE_LOG": str(self._log), **more}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        command, pipe = [sys.executable, "-c", code], subprocess.PIPE
        return subprocess.Popen(command, env=environment, cwd=self.folder, text=True, stdout=pipe, stderr=pipe)

    def finish(self, *running: subprocess.Popen[str]) -> Ran:
        found = [process.communicate(timeout=120) for process in running]
        out, err = ("".join(texts) for texts in zip(*found, strict=True))
        assert not any(process.returncode for process in running), err
        lines = self._log.read_text().splitlines() if self._log.exists() else []
        self._log.unlink(missing_ok=True)
        return Ran(out.strip(), err, Counter(line.split()[0] for line in lines))

    def run(self, code: str = TOP, **more: str) -> Ran:
        return self.finish(self.start(code, **more))

    def edit(self, file: str, before: str, after: str) -> None:
        """Change a text of the same size, and set the time back."""
        path = self.package / file
        status, text = path.stat(), path.read_text("utf-8")
        assert before in text
        assert len(before) == len(after)
        path.write_text(text.replace(before, after), "utf-8")
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))

    def kernels(self) -> list[Path]:
        return sorted(self.cache.glob("*.kernel"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("copy")
    ignored = shutil.ignore_patterns("__pycache__", "assets")
    shutil.copytree(SOURCE, folder / "src" / "holonom", ignore=ignored)
    for name, text in CHAIN.items():
        path = folder / "src" / "holonom" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return folder


@pytest.fixture
def copy(folder: Path) -> Copy:
    shutil.rmtree(folder / "cache", ignore_errors=True)
    return Copy(folder)


def test_an_edit_two_files_away_is_seen_whatever_the_time_says(copy: Copy) -> None:
    first, again = copy.run(), copy.run()
    assert (first.out, first.kernels) == ("21.0", {"compiled": 3})
    assert (again.out, again.kernels) == ("21.0", {"loaded": 1})
    copy.edit("chain/far.py", "FACTOR = 2.0", "FACTOR = 3.0")
    edited = copy.run()
    assert (edited.out, edited.kernels) == ("31.0", {"compiled": 3})
    copy.edit("chain/far.py", "FACTOR = 3.0", "FACTOR = 2.0")
    back = copy.run()
    assert (back.out, back.kernels) == ("21.0", {"loaded": 1})
    assert not list(copy.package.rglob("*.nb?"))


def test_an_edited_position_step_is_seen_by_what_inlines_it(copy: Copy) -> None:
    code = "from holonom.chain.top import stepped\nprint(stepped(10.0))"
    before = float(copy.run(code).out)
    copy.edit("control/servo/kernels.py", "(2.0 * distance", "(5.0 * distance")
    after = float(copy.run(code).out)
    copy.edit("control/servo/kernels.py", "(5.0 * distance", "(2.0 * distance")
    assert (before, after) == pytest.approx((19.0**0.5, 49.0**0.5), rel=1e-15)


def test_an_edit_while_a_process_runs_does_not_reach_the_cache_under_the_wrong_text(copy: Copy) -> None:
    edit = "import pathlib, holonom.chain.far as far\npath = pathlib.Path(far.__file__)\n"
    edit += "path.write_text(path.read_text().replace('FACTOR = 2.0', 'FACTOR = 4.0'))\n"
    during = copy.run(TOP.replace("\n", f"\n{edit}"))
    assert (during.out, copy.kernels()) == ("21.0", [])
    assert during.err.count("\n") == 1
    assert "start again" in during.err
    assert copy.run().out == "41.0"
    copy.edit("chain/far.py", "FACTOR = 4.0", "FACTOR = 2.0")


def test_two_processes_at_once_compile_once(copy: Copy) -> None:
    wait = "import pathlib, time\nwhile not pathlib.Path('go').exists():\n    time.sleep(0.001)\n"
    code = TOP.replace("\n", f"\nprint(flush=True)\n{wait}")
    running = [copy.start(code) for _ in range(2)]
    for process in running:
        assert process.stdout
        process.stdout.readline()
    (copy.folder / "go").touch()
    both = copy.finish(*running)
    assert both.out.split() == ["21.0", "21.0"]
    assert both.kernels["compiled"] == 3
    assert both.kernels["loaded"] >= 1


@pytest.mark.skipif(cache.fcntl is None, reason="no locks on this system")
def test_a_killed_process_lets_others_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    code = "from holonom.trace.code.cache import Entry\nEntry('a', 'f00d').lock()\nprint(flush=True)\ninput()"
    holder = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert holder.stdout
    assert holder.stdin
    holder.stdout.readline()
    place = cache._place(Entry("a", "f00d").path)
    assert not cache._lock(tmp_path, place, wait=False)
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    Entry("a", "f00d").lock()  # for ever, if the lock had stayed
    Entry("a", "f00d").unlock()
    holder.stdin.close()
    holder.stdout.close()


FULL = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))\n"


@pytest.mark.parametrize(("named", "before"), [("/proc/holonom", ""), (__file__, ""), (None, FULL)])
def test_a_cache_that_cannot_be_written_costs_a_line(copy: Copy, named: str | None, before: str) -> None:
    """A folder that is not to be made, one that is a file, and a full one (a limit on the size of files)."""
    ran = copy.run(before + TOP, **({"HOLONOM_CACHE": named} if named else {}))
    assert (ran.out, ran.kernels) == ("21.0", {"compiled": 3})
    assert ran.err.count("\n") == 1
    assert "set HOLONOM_CACHE to" in ran.err
    assert copy.kernels() == []


def test_damaged_files_are_made_anew(copy: Copy) -> None:
    copy.run()
    far, near, top = copy.kernels()
    for path, data in ((far, b""), (near, near.read_bytes()[:5000]), (top, os.urandom(3000))):
        path.write_bytes(data)
    ran = copy.run()
    assert (ran.out, ran.kernels) == ("21.0", {"compiled": 3})
    assert ran.err.count("\n") == 1
    assert "damaged" in ran.err
    whole = copy.run()
    assert (whole.out, whole.err, whole.kernels) == ("21.0", "", {"loaded": 1})


def test_what_was_used_longest_ago_goes_first_but_not_what_is_held(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    monkeypatch.setenv("HOLONOM_CACHE_LIMIT", "4K")
    entries = [Entry(f"k{k}", f"{k:04x}") for k in range(5)]
    for entry in entries:
        entry.path.write_bytes(bytes(1000))
    for k in (4, 0, 2, 1, 3):  # from the oldest to the newest
        os.utime(entries[k].path, (1000.0 + k if k == 4 else 2000.0 + k, 1.0))
    holding = "from holonom.trace.code.cache import Entry\nEntry('k4', '0004')._hold()\nprint(flush=True)\ninput()"
    command = [sys.executable, "-c", holding]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as holder:
        assert holder.stdin
        assert holder.stdout
        holder.stdout.readline()
        Entry("new", "00ff").write(bytes(100))
        left = {path.name[:2] for path in tmp_path.glob("*.kernel")}
        holder.stdin.close()
    assert left == ({"k2", "k3", "k4", "ne"} if cache.fcntl else {"k1", "k2", "k3", "ne"})
    assert cache_use().size < cache_use().limit


def test_the_cache_is_emptied_and_says_why_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    Entry("a", "f00d").write(b"1234")
    assert empty_cache()[1:3] == (1, 36)
    assert cache_use().kernels == 0
    (tmp_path / "b-00.kernel").mkdir()
    with pytest.raises(OutputError, match="cannot be removed"):
        empty_cache()
