"""Fixtures that several test folders share: reference data, peer libraries, the Hypothesis profile."""

from __future__ import annotations

import fcntl
import functools
import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import settings
from kernel_log import compile_seconds

ROOT = Path(__file__).resolve().parents[1]

settings.register_profile("holonom", deadline=None, print_blob=True, max_examples=50)
settings.load_profile("holonom")


def pytest_configure(config: pytest.Config) -> None:
    """Let every process of the session, workers and programs too, write down which kernels it compiles and loads."""
    if "HOLONOM_CACHE_LOG" not in os.environ:
        folder = tempfile.TemporaryDirectory(prefix="holonom-")
        config.add_cleanup(folder.cleanup)
        os.environ["HOLONOM_CACHE_LOG"] = os.path.join(folder.name, "kernels")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Of an unchanged tree, the second run compiles none (tests of compiling itself keep their own count)."""
    log = Path(os.environ["HOLONOM_CACHE_LOG"])
    lines = log.read_text("utf-8").splitlines() if log.exists() else []
    compiled = [line.split(maxsplit=4)[1:] for line in lines if line.startswith("compiled ")]
    seconds = compile_seconds((int(process), float(begin), float(end)) for process, begin, end, _ in compiled)
    terminalreporter.write_line(
        f"kernels: {len(compiled)} compiled in {seconds:.1f} CPU s, {len(lines) - len(compiled)} loaded"
    )
    for title in sorted({title for *_, title in compiled})[:20]:
        terminalreporter.write_line(f"  compiled {title}")


BATCHES = ("tests/trace/", "test_long_chain.py", "test_batches.py")


@pytest.fixture(autouse=True)
def batch_forms(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the batch form of kernels is the subject it is compiled for the first rows, elsewhere as for users."""
    subject = any(part in str(request.path) for part in BATCHES)
    monkeypatch.setattr("holonom.trace.kernel.FEW", 0 if subject else 2000)


@pytest.fixture(scope="session")
def root() -> Path:
    """Root of the repository."""
    return ROOT


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder with the published reference data: HOLONOM_DATA, or `shared/data` beside the repository."""
    folder = Path(os.environ.get("HOLONOM_DATA", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no reference data in {folder}; set HOLONOM_DATA to the folder that holds them")
    return folder.resolve()


@pytest.fixture(scope="session")
def pinocchio() -> ModuleType:
    """Pinocchio (package `pin`)."""
    return _peer("pinocchio")


@pytest.fixture(scope="session")
def eaik() -> ModuleType:
    """Closed-form inverse kinematics by subproblem decomposition, with its DH robots loaded."""
    _peer("eaik.IK_DH")
    return _peer("eaik")


@pytest.fixture(scope="session")
def roboticstoolbox() -> ModuleType:
    """Corke's robotics toolbox."""
    return _peer("roboticstoolbox")


@pytest.fixture(scope="session")
def example_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Run an example's cell once per session, as a user does; give its run folder ("01_sort_coins" -> path)."""
    shared = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shared = shared.parent

    @functools.cache
    def run(name: str) -> Path:
        folder = shared / "examples" / name
        folder.parent.mkdir(exist_ok=True)
        with folder.with_suffix(".lock").open("w") as lock:  # of two workers one runs it, the other one waits
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not folder.exists():
                cell = ROOT / "examples" / name / "cell.toml"
                command = [sys.executable, "-m", "holonom", "run", cell, "-o", folder, "--quiet"]
                done = subprocess.run(command, capture_output=True, text=True, check=False)
                assert done.returncode == 0, done.stderr
        return folder

    return run


def _peer(name: str) -> ModuleType:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # warnings of the peer's own imports are not our errors
        return pytest.importorskip(
            name, reason=f"peer {name} is not installed; pip install -e '.[oracle]'", exc_type=ImportError
        )
