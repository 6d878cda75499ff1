"""The package alone, as `pip install .` leaves it: what needs more says which extra, and nothing else needs it."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from holonom.app.about.doctor import EXTRAS
from holonom.errors import MissingExtra

ROOT = Path(__file__).resolve().parents[2]
BLOCKED = sorted({module for extra in EXTRAS.values() for module in extra.modules} - {"pytest"})
MAIN = """
import sys
for name in {blocked}:
    sys.modules[name] = None
from holonom.__main__ import main
sys.argv[1:] = {words}
sys.exit(main())
"""


def alone(*words: object) -> subprocess.CompletedProcess[str]:
    code = MAIN.format(blocked=BLOCKED, words=[str(word) for word in words])
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone")
    text = (
        '[cell]\nname = "x"\ntime_limit = "5s"\n[[robot]]\nmodel = "planar2r"\ndrives = "ideal"\nprogram = "p.arps"\n'
    )
    (folder / "cell.toml").write_text(text, "utf-8")
    (folder / "p.arps").write_text('.PROGRAM main()\nTYPE "hello"\n.END\n', "utf-8")
    return folder / "cell.toml"


def test_an_arm_cell_and_a_program(cell: Path) -> None:
    for words in (["check", cell.parent / "p.arps"], ["check", cell], ["run", cell, "-o", cell.parent / "out"]):
        done = alone(*words)
        assert done.returncode == 0, done.stderr
    assert alone("report", cell.parent / "out" / "recording.mcap").returncode == 0


def test_a_base_cell_and_the_tables() -> None:
    assert alone("check", ROOT / "examples" / "03_soccer_robot" / "cell.toml").returncode == 0
    assert alone("methods").returncode == 0
    done = alone("doctor")
    assert done.returncode == 0
    assert "in the clone, pip install -e" in done.stdout


def test_a_photograph_names_its_extra() -> None:
    done = alone("check", ROOT / "examples" / "01_sort_coins" / "cell.toml")
    assert done.returncode == 2
    assert done.stderr.startswith("holonom: error: a photograph needs OpenCV, which is not installed")
    assert "pip install -e '.[vision]'" in done.stderr


def test_every_extra_that_is_named_is_there() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    named = set()
    for path in (ROOT / "src").rglob("*.py"):
        text = path.read_text("utf-8")
        named |= {extra for extra in extras if 'MissingExtra("' in text and f', "{extra}")' in text}
    assert named >= {"vision", "xacro", "plots", "symbolic", "motion"}
    said = str(MissingExtra("a thing", "A Library", "vision"))
    assert "a thing needs A Library" in said


def test_nobody_is_told_to_install_a_name_from_an_index() -> None:
    """There is no holonom on any index: whoever takes that name would be run by whoever was told so."""
    places = [*(ROOT / "src").rglob("*.py"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "tests").rglob("*.py")]
    told = "pip install " + "holonom", "pip install '" + "holonom[", 'pip install "' + "holonom["
    for path in [*places, ROOT / "README.md"]:
        for line in path.read_text("utf-8").splitlines():
            assert not any(word in line and " @ " not in line for word in told), (path, line)
