"""Bounds of every reader: what is too large, too long, too deep or too small is named, at once, with its line."""

from __future__ import annotations

import gzip
import os
import re
import struct
import time
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from holonom.app.cell import load_cell
from holonom.app.console.cli import main
from holonom.app.odometry_log.plain import read_description
from holonom.app.odometry_log.reader import read_log
from holonom.app.odometry_log.table import read_table
from holonom.errors import CellError, HolonomError, ImageError, LogError, ModelError, ProgramError
from holonom.files import LIMITS, LINE_LENGTH, LINES, check_lines, read_bytes, read_text
from holonom.lang import load_program, read_locations
from holonom.mechanics import load_arm
from holonom.vision import load_photograph

CELL = '[cell]\nname = "x"\ntime_limit = "1s"\n[[robot]]\nmodel = "planar2r"\ndrives = "ideal"\nhold = "1s"\n'
PROGRAM = ".PROGRAM main()\n{}\n.END\n"
READERS = {
    "cell.toml": (load_cell, CellError),
    "p.arps": (load_program, ProgramError),
    "r.urdf": (load_arm, ModelError),
    "run.csv": (read_table, LogError),
    "log.toml": (read_description, LogError),
    "photo.png": (load_photograph, ImageError),
}


def refused(read, path: Path, kind: type[HolonomError]) -> str:
    """What a reader says of a file; a second is more than it may take."""
    begin = time.process_time()
    with pytest.raises(kind) as error:
        read(path)
    assert time.process_time() - begin < 1.0
    assert str(path) in str(error.value)
    assert str(error.value).count("cannot be read") <= 1
    return str(error.value)


@pytest.mark.parametrize("name", READERS)
def test_what_is_no_file_is_refused(name: str, tmp_path: Path) -> None:
    """A folder, a pipe, a device without end, a circle of links, nothing."""
    read, kind = READERS[name]
    path = tmp_path / name
    assert "No such file" in refused(read, path, kind)
    path.mkdir()
    assert "Is a directory" in refused(read, path, kind)
    path.rmdir()
    os.mkfifo(path)
    assert "a device or pipe" in refused(read, path, kind)
    path.unlink()
    path.symlink_to("/dev/zero")
    assert "a device or pipe" in refused(read, path, kind)
    path.unlink()
    path.symlink_to(path)
    assert "cannot be read" in refused(read, path, kind)


@pytest.mark.parametrize("name", READERS)
def test_what_is_too_large_is_refused_unread(name: str, tmp_path: Path) -> None:
    """A sparse file of a terabyte."""
    read, kind = READERS[name]
    with (tmp_path / name).open("wb") as file:
        file.truncate(2**40)
    said = refused(read, tmp_path / name, kind)
    limit = re.search(r"more than (\d+) MiB", said)
    assert int(limit[1]) in {what.most >> 20 for what in LIMITS.values()}


@pytest.mark.parametrize("name", [name for name in READERS if not name.endswith(".png")])
def test_a_byte_order_mark_is_passed_over(name: str, tmp_path: Path) -> None:
    text = {
        "cell.toml": CELL,
        "p.arps": PROGRAM.format('TYPE "x"'),
        "r.urdf": '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/>'
        '<child link="b"/><axis xyz="0 0 1"/></joint></robot>',
        "run.csv": "time,left\n0,1\n1,2\n",
        "log.toml": 'drive = "differential"\nruns = ["a.csv"]\n[geometry]\nwheelbase = 0.2\ndiameter_left = 0.1\n'
        "diameter_right = 0.1\n",
    }[name]
    for data in (b"\xef\xbb\xbf" + text.encode(), b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode()):
        (tmp_path / name).write_bytes(data)
        READERS[name][0](tmp_path / name)
    (tmp_path / "p.loc").write_bytes(b"\xef\xbb\xbfthere = 1, 2, 3, 0, 0, 0\r\n")
    assert list(read_locations(read_text(tmp_path / "p.loc", "locations", ProgramError), "p.loc")) == ["there"]


def test_a_packed_log_is_unpacked_no_further_than_a_log_may_be(tmp_path: Path) -> None:
    """A gigabyte of zeros in a megabyte; six of those would be six gigabytes."""
    path = tmp_path / "run.csv.gz"
    member = gzip.compress(bytes(2**24), compresslevel=9)
    path.write_bytes(gzip.compress(b"time,left\n") + 70 * member)
    assert "more than 128 MiB" in refused(read_table, path, LogError)
    for broken in (member[:1000], b"\x1f\x8b" + bytes(20), member[:-8] + bytes(8)):
        path.write_bytes(broken)
        with pytest.raises(LogError, match="no gzip file, or damaged"):
            read_table(path)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("".join(f"k{k} = 1\n" for k in range(80_000)), 10001, "more than 10000 keys and tables"),
        ("[[fault]]\n" * 80_000, 10001, "more than 10000 keys and tables"),
        ("seed = " + "9" * 6000, 8, "6000 characters; at most 300"),
        ("seed = 0x" + "f" * 6000, 8, "6002 characters; at most 300"),
        ("x = " + "[" * 50_000, 8, "at most 100 tables and lists in each other"),
        ("x = " + "[" * 50_000 + "]" * 50_000, 8, "at most 100 tables and lists in each other"),
        ("\nx = " + "{a = " * 50_000, 9, "at most 100 tables and lists in each other"),
        ("[" + "a." * 50_000 + "a]", 8, "at most 100 tables and lists in each other"),
        ("a" * 6000 + " = 1", 8, "6000 characters; at most 300"),
    ],
)
def test_toml_without_measure(text: str, line: int, said: str, tmp_path: Path) -> None:
    for name, (read, kind) in (("cell.toml", READERS["cell.toml"]), ("log.toml", READERS["log.toml"])):
        (tmp_path / name).write_text(CELL + text + "\n", "utf-8")
        found = refused(read, tmp_path / name, kind)
        assert f"{name}:{line}: " in found
        assert said in found
        assert len(found) < 500


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("x = " + "9" * 6000, r":2:5: 9{20}\.\.\. \(6000 characters\) is too large a number"),
        ("x = " + "(" * 5000 + "1" + ")" * 5000, r":2:\d+: nested too deeply: 300 levels"),
        ("\n" * 30_000, r":20001: more than 20000 lines"),
        ('TYPE "' + "a" * 30_000 + '"', r":2: 30007 characters in a line; at most 20000"),
        ("IF 1 THEN\n" * 5000 + "END\n" * 5000, r"nested too deeply: 300 levels"),
    ],
)
def test_programs_without_measure(body: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "p.arps").write_text(PROGRAM.format(body), "utf-8")
    with pytest.raises(ProgramError, match=said) as refused:
        load_program(tmp_path / "p.arps")
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize("value", ["9" * 6000, "1e999", "1_0", "\u0663", "0x10", "1e", ""])
def test_locations_hold_numbers(value: str) -> None:
    with pytest.raises(ProgramError, match=r"p\.loc:2:\d+: "):
        read_locations(f"; first\nhere = 1, 2, {value}, 0, 0, 0\n", "p.loc")


def test_tables_without_measure() -> None:
    check_lines("x\n" * LINES, "run.csv", LogError)
    with pytest.raises(LogError, match=rf"run\.csv:{LINES + 1}: more than {LINES} lines"):
        check_lines("x\n" * (LINES + 1), "run.csv", LogError)
    with pytest.raises(LogError, match=rf"run\.csv:2: {LINE_LENGTH + 1} characters in a line"):
        check_lines("x\n" + "1" * (LINE_LENGTH + 1), "run.csv", LogError)


def test_twenty_faults_are_told(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(CELL + "".join(f"k{k} = 1\n" for k in range(3000)), "utf-8")
    said = refused(load_cell, tmp_path / "cell.toml", CellError).splitlines()
    assert len(said) == 21
    assert [line.split(":")[1] for line in said[:20]] == [str(8 + k) for k in range(20)]
    assert said[20].endswith("and 2980 more faults")
    (tmp_path / "cell.toml").write_text(CELL.replace('"planar2r"', "[" + '"a",' * 5000 + "]"), "utf-8")
    assert len(refused(load_cell, tmp_path / "cell.toml", CellError)) < 1500


def test_cells_of_a_log_in_quotes(tmp_path: Path) -> None:
    """RFC 4180, of columns that are read and of others."""
    path = tmp_path / "run.csv"
    path.write_text('"time",note,left\n0,"a, ""b""; c","1.5"\n1,plain,-2\n', "utf-8")
    table = read_table(path, needed={"time", "left"})
    assert table.names == ("time", "left")
    np.testing.assert_array_equal(table.values, [[0.0, 1.5], [1.0, -2.0]])
    path.write_text('time,note,left\n0,"a, b,1\n1,c,2\n', "utf-8")
    assert "run.csv:2: quotes that do not enclose a cell" in refused(read_table, path, LogError)


@pytest.mark.parametrize("value", ["1_0", "\u0663", "0x10", "1e"])
def test_logs_hold_numbers(value: str, tmp_path: Path) -> None:
    (tmp_path / "run.csv").write_text(f"time,left\n0,1\n1,{value}\n", "utf-8")
    assert "run.csv:3: column 2 (left)" in refused(read_table, tmp_path / "run.csv", LogError)


@pytest.mark.parametrize("digit", ["\u0663", "\uff13"])
def test_programs_and_cells_hold_digits_of_ascii(digit: str, tmp_path: Path) -> None:
    (tmp_path / "p.arps").write_text(PROGRAM.format(f"DELAY {digit}"), "utf-8")
    assert "p.arps:2:" in refused(load_program, tmp_path / "p.arps", ProgramError)
    (tmp_path / "cell.toml").write_text(CELL.replace("1s", f"{digit}s"), "utf-8")
    assert "cell.toml:3: cell.time_limit" in refused(load_cell, tmp_path / "cell.toml", CellError)


@pytest.mark.parametrize("name", [name for name in READERS if not name.endswith((".png", ".urdf"))])
def test_a_zero_character_is_named_where_it_stands(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(b"# a\n0\x00,0\n")
    assert f"{name}:2: a character of number 0" in refused(READERS[name][0], tmp_path / name, READERS[name][1])


def test_a_log_shows_no_line_of_a_file_that_is_none(tmp_path: Path) -> None:
    """The description of a log may be a stranger's, and name any file."""
    secret = "root:$6$salt$secretsecretsecret:19000:0:99999:7:::"
    (tmp_path / "shadow").write_text(f"{secret}\n{secret}\n", "utf-8")
    (tmp_path / "keys.csv").write_text(f"time,left,right\n0,{secret},1\n1,2,3\n", "utf-8")
    for name in ("shadow", "keys.csv"):
        (tmp_path / "log.toml").write_text(
            f'drive = "differential"\nruns = ["{name}"]\n[geometry]\nwheelbase = 0.2\ndiameter_left = 0.1\n'
            "diameter_right = 0.1\n",
            "utf-8",
        )
        with pytest.raises(LogError) as refused:
            read_log([tmp_path / "log.toml"])
        assert "secret" not in str(refused.value)


def png(width: int, height: int) -> bytes:
    """A PNG of one grey, its pixels packed a thousandfold."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    pixels = zlib.compress(bytes(min((width + 1) * height, 2**24)), 9)
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


@pytest.mark.parametrize("size", [(65_500, 65_500), (2**31 - 1, 32), (20_000, 40), (10_000, 4_001), (31, 400), (0, 0)])
def test_a_photograph_that_unpacks_to_gigabytes(size: tuple[int, int], tmp_path: Path) -> None:
    (tmp_path / "p.png").write_bytes(png(*size))
    said = refused(load_photograph, tmp_path / "p.png", ImageError)
    assert (
        f"has {size[0]} x {size[1]} pixels; 32 x 32 is the least, 16384 a side and 40 megapixels are the most" in said
    )


@pytest.mark.parametrize("ending", ["png", "jpg", "tiff", "bmp"])
def test_the_head_of_a_file_says_its_size(ending: str, tmp_path: Path) -> None:
    """As OpenCV unpacks it, of every format that is read; cut anywhere it is no image, or the same."""
    from holonom.vision.image_size import stated_size

    image = np.random.default_rng(1).integers(0, 255, (48, 67), dtype=np.uint8)
    data = cv2.imencode(f".{ending}", image)[1].tobytes()
    assert stated_size(data) == (67, 48)
    (tmp_path / "p").write_bytes(data)
    assert load_photograph(tmp_path / "p").shape == (48, 67)
    for size in range(0, len(data), 7):
        assert stated_size(data[:size]) in (None, (67, 48))


def test_a_coin_of_250_kilometres(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Millimetres taken for kilometres: named by the calibration's points, or by the layout."""
    example = Path(__file__).resolve().parents[2] / "examples" / "01_sort_coins"
    for file in example.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    rows = (tmp_path / "coins.csv").read_text("utf-8").splitlines()
    rows[1] = re.sub(r"[^,]+$", "90000", rows[1])
    (tmp_path / "coins.csv").write_text("\n".join(rows) + "\n", "utf-8")
    assert main(["check", str(tmp_path / "cell.toml")]) == 2
    said = capsys.readouterr().err
    assert re.search(r"coins\.csv: part \d+ has a diameter of [\d.e+]+ m", said)
    assert "parts of 0.1 mm to 1 m within 100 m are allowed" in said
    head = '[cell]\nname = "x"\ntime_limit = "1s"\n[[robot]]\n'
    track = head + 'model = {{ arrangement = "mecanum", wheelbase = "300mm", track = "{}", '
    rest = 'wheel_radius = "50mm", mass = "15kg" }}\nhold = "1s"\n'
    for length in ("250km", "1e308mm", "1e999999999mm"):
        (tmp_path / "base.toml").write_text((track + rest).format(length), "utf-8")
        assert main(["check", str(tmp_path / "base.toml")]) == 2
        assert "base.toml:5: robot[0].model.track: " in capsys.readouterr().err


def test_a_size_is_looked_at_before_it_is_read(tmp_path: Path) -> None:
    (tmp_path / "x").write_bytes(b"1" * 100)
    assert read_bytes(tmp_path / "x", "program", ProgramError) == b"1" * 100
    (tmp_path / "x").write_bytes(b"\xff")
    with pytest.raises(ProgramError, match=r"x:1: not UTF-8"):
        read_text(tmp_path / "x", "program", ProgramError)


@pytest.mark.parametrize("number", ["1e308", "-1e101", "9" * 6000, "nan", "1_0", "\u0663"])
def test_numbers_of_robots(number: str, tmp_path: Path) -> None:
    """What overflows once it is squared is told where it stands."""
    (tmp_path / "r.urdf").write_text(
        '<robot name="r"><link name="a"/><link name="b"/>\n<joint name="j" type="continuous"><parent link="a"/>'
        f'<child link="b"/>\n<origin xyz="0 {number} 0"/></joint></robot>',
        "utf-8",
    )
    said = refused(load_arm, tmp_path / "r.urdf", ModelError)
    assert "line 3: <origin> xyz=" in said
    assert len(said) < 300
