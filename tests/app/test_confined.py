"""A cell's folder is its world: what it names lies there, and no error shows a line of another file."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from holonom.app.cell import load_cell
from holonom.app.console.cli import main
from holonom.errors import CellError, ProgramError
from holonom.lang import load_program

SECRET = "root:$6$salt$secret:19000:0:99999:7:::"
CELL = """
[cell]
name = "confined"
time_limit = "1s"
[[robot]]
model = "planar2r"
drives = "ideal"
"""
COINS = Path(__file__).resolve().parents[2] / "examples" / "01_sort_coins"


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    """A file of somebody else, above the cell's folder."""
    path = tmp_path / "shadow"
    path.write_text(f"{SECRET}\n", "utf-8")
    (tmp_path / "cell" / "sub").mkdir(parents=True)
    return path


def ways(secret: Path, folder: Path, name: str) -> Iterator[str]:
    """By an absolute path, by a relative one, by links to the file and to its folder, and by both."""
    yield str(secret)
    yield f"../{secret.name}"
    yield f"./sub/../../{secret.name}"
    os.symlink(secret, folder / name)
    yield name
    os.symlink(secret.parent, folder / "linked")
    yield f"linked/{secret.name}"


KEYS = {
    "program": 'program = "{}"',
    "program.file": 'program = {{ file = "{}" }}',
    "program.locations": 'program = {{ file = "p.arps", locations = "{}" }}',
}


@pytest.mark.parametrize("key", KEYS)
def test_a_program_lies_in_the_cells_folder(key: str, secret: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = secret.parent / "cell"
    (folder / "p.arps").write_text(".PROGRAM main()\n.END\n", "utf-8")
    for number, given in enumerate(ways(secret, folder, "mine.arps")):
        (folder / "cell.toml").write_text(CELL + KEYS[key].format(given), "utf-8")
        for words in (["check"], ["run", "-o", str(folder / f"out{number}")], ["run", "--seed", "1", "-o", "out"]):
            assert main([*words, str(folder / "cell.toml")]) == 2
            said = capsys.readouterr()
            assert "leads out of the cell's folder" in said.err
            assert "--allow-outside" in said.err
            assert "cell.toml:8: robot[0].program" in said.err
            assert "secret" not in said.err + said.out
        assert not (folder / f"out{number}").exists()
        assert main(["check", "--allow-outside", str(folder / "cell.toml")]) == 2  # read, and no program
        assert "leads out" not in capsys.readouterr().err


def test_the_location_file_beside_a_program_is_confined_too(secret: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = secret.parent / "cell"
    (folder / "p.arps").write_text(".PROGRAM main()\n.END\n", "utf-8")
    (folder / "cell.toml").write_text(CELL + 'program = "p.arps"', "utf-8")
    os.symlink(secret, folder / "p.loc")
    for words in (["check", str(folder / "cell.toml")], ["check", str(folder / "p.arps")]):
        assert main(words) == 2
        said = capsys.readouterr().err
        assert "leads out of the" in said
        assert "secret" not in said
    with pytest.raises(ProgramError, match="link that leads out"):
        load_program(folder / "p.arps")
    with pytest.raises(ProgramError, match="this is no location"):
        load_program(folder / "p.arps", allow_outside=True)


@pytest.mark.parametrize("key", ["photograph", "layout"])
def test_what_the_camera_needs_is_confined(key: str, secret: Path) -> None:
    folder = secret.parent / "cell"
    text = (COINS / "cell.toml").read_text("utf-8")
    for file in COINS.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    name = {"photograph": "coins.png", "layout": "coins.csv"}[key]
    assert f'{key} = "{name}"' in text
    load_cell(folder / "cell.toml")
    for given in ways(secret, folder, "mine"):
        (folder / "cell.toml").write_text(text.replace(f'{key} = "{name}"', f'{key} = "{given}"'), "utf-8")
        with pytest.raises(CellError, match="leads out of the cell's folder") as refused:
            load_cell(folder / "cell.toml")
        assert "secret" not in str(refused.value)
        load_cell(folder / "cell.toml", allow_outside=True)


def test_links_within_the_folder_and_to_it_are_no_way_out(tmp_path: Path) -> None:
    """Nor is a cell that is reached by a link, or lies in a folder that is one."""
    folder = tmp_path / "cell"
    (folder / "programs").mkdir(parents=True)
    (folder / "programs" / "p.arps").write_text(".PROGRAM main()\n.END\n", "utf-8")
    os.symlink(folder / "programs" / "p.arps", folder / "q.arps")
    for name in ("programs/p.arps", "q.arps", "./programs/../q.arps"):
        (folder / "cell.toml").write_text(CELL + f'program = "{name}"', "utf-8")
        load_cell(folder / "cell.toml")
    os.symlink(folder, tmp_path / "other")
    load_cell(tmp_path / "other" / "cell.toml")


def test_robots_may_lie_anywhere_and_show_no_line(secret: Path) -> None:
    folder = secret.parent / "cell"
    for given in (str(secret), f"../{secret.name}"):
        text = f'[cell]\nname = "x"\n[[robot]]\nmodel = {{ file = "{given}" }}\nhold = "1s"\n'
        (folder / "cell.toml").write_text(text, "utf-8")
        with pytest.raises(CellError) as refused:
            load_cell(folder / "cell.toml")
        assert "leads out" not in str(refused.value)
        assert "secret" not in str(refused.value)
