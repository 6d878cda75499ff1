"""The wheel alone, without a clone: its examples and its first cells run."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

from holonom import __version__

ROOT = Path(__file__).resolve().parents[1]
NEEDED = ("hatchling", "pip")


def call(*command: str | Path, folder: Path) -> str:
    """What a command prints, after status 0; it sees no package but those of its own Python."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel of this tree, built without the network."""
    missing = [name for name in NEEDED if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"{' and '.join(missing)} not installed; pip install -e '.[test]'")
    folder = tmp_path_factory.mktemp("dist")
    call(sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder, folder=ROOT)
    (found,) = folder.glob("*.whl")
    return found


@pytest.fixture(scope="module")
def python(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of a fresh environment with the wheel; what that depends on is this environment's.

    The clone is not: `.pth` files, by which clones are installed, count in an environment's own folder only.
    """
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=True)
    found = folder / "bin" / "python"
    call(sys.executable, "-m", "pip", "--python", found, "install", "--no-deps", "--no-index", wheel, folder=folder)
    (own,) = folder.glob("lib/python*/site-packages")
    others = [path for path in sys.path if Path(path).name in ("site-packages", "dist-packages")]
    (own / "others.pth").write_text("\n".join(others) + "\n", "utf-8")
    return found


def test_a_wheel_holds_the_package_and_the_examples_and_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    shipped = {name.removeprefix("holonom/app/start/") for name in names if "/examples/" in name}
    tracked = {path.relative_to(ROOT).as_posix() for path in (ROOT / "examples").rglob("*") if path.is_file()}
    assert shipped == {name for name in tracked if "/runs/" not in name and "__pycache__" not in name}
    assert {name.split("/")[0] for name in names} == {"holonom", f"holonom-{__version__}.dist-info"}


def test_the_wheel_alone_runs_its_demo_and_a_new_cell(python: Path, tmp_path: Path) -> None:
    holonom = python.with_name("holonom")
    code = "import holonom; print(holonom.__file__)"
    assert Path(call(python, "-c", code, folder=tmp_path).strip()).is_relative_to(python.parents[1])
    before = {path: path.stat().st_mtime_ns for path in python.parents[1].rglob("examples/*/*")}
    assert before
    out = call(holonom, "demo", "soccer_robot", folder=tmp_path)
    assert f"report: {Path('runs', '03_soccer_robot', 'report.html')}" in out
    assert (tmp_path / "runs" / "03_soccer_robot" / "report.html").is_file()
    assert {path: path.stat().st_mtime_ns for path in python.parents[1].rglob("examples/*/*")} == before
    assert "next: holonom run first/cell.toml" in call(holonom, "new", "arm", "first", folder=tmp_path)
    assert "report: runs/first/report.html" in call(holonom, "run", "first/cell.toml", folder=tmp_path)
