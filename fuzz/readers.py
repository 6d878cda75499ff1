"""The readers, each as one function of a file, with seeds of its own and words that its format has."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["READERS", "SEEDS", "Reader"]

SEEDS = Path(__file__).parent / "seeds"
"""A folder for each reader."""


@dataclass(frozen=True, slots=True)
class Reader:
    """How a file is read; its ending; words of its format; how many inputs there are unless another count is given."""

    read: Callable[[Path], object]
    ending: str
    words: str = ""
    count: int = 100_000
    pack: Callable[[bytes], bytes] | None = None
    """made of what was changed, so that checksums are right"""


def _cell(path: Path) -> object:
    from holonom.app.cell import load_cell

    return load_cell(path)


def _program(path: Path) -> object:
    from holonom.lang import load_program

    return load_program(path)


def _locations(path: Path) -> object:
    from holonom.errors import ProgramError
    from holonom.files import read_text
    from holonom.lang import read_locations

    return read_locations(read_text(path, "locations", ProgramError), str(path))


def _robot(path: Path) -> object:
    from holonom.model import load_model

    return load_model(path)


def _table(path: Path) -> object:
    from holonom.app.odometry_log.table import read_table

    return read_table(path)


def _layout(path: Path) -> object:
    from holonom.app.cell.build.camera import _read_layout

    return _read_layout(path)


def _metadata(path: Path) -> object:
    from holonom.app.odometry_log.optiodom import drive_of

    return drive_of(path)


def _description(path: Path) -> object:
    from holonom.app.odometry_log.plain import read_description

    return read_description(path)


def _sheet(path: Path) -> object:
    from holonom.app.drives.tuning.file import tune_file

    return tune_file(path)


def _drive(path: Path) -> object:
    """A motor or axis, else a load cycle, as far as its JSON."""
    import json

    from holonom.app.drives.check import check_drive
    from holonom.app.drives.files import is_drive
    from holonom.app.drives.select import select

    return json.dumps((check_drive if is_drive(path) else select)(path).data, allow_nan=False)


def _recording(path: Path) -> object:
    from holonom.app.recording import read_robots

    return read_robots(path)


def _words(path: Path) -> object:
    """What a recording says of its cell, scene, photograph, base and end."""
    from holonom.app.recording import Recording
    from holonom.app.recording.robot import base_of
    from holonom.app.report.attached import cell_of, ending_of, photograph_of, recorded_scene
    from holonom.errors import InputError

    data = path.read_bytes()
    text = data.decode("utf-8", "replace")
    names = "cell.json", "scene.json", "photograph.json", "photograph.png"
    words = {"outcome": {"statistics": text}, "robot": {"kind": "base", "description": text}}
    whole = Recording(attachments=dict.fromkeys(names, data), metadata=words)
    problems = []
    for read in (cell_of, recorded_scene, photograph_of, ending_of, lambda found: base_of(found.metadata)):
        try:
            read(whole)
        except InputError as error:
            problems.append(error)
    return problems


def _image(path: Path) -> object:
    from holonom.vision import load_photograph

    return load_photograph(path)


def _in_a_chunk(data: bytes) -> bytes:
    """A recording of one chunk that holds these bytes, with the right checksum."""
    body = bytes(8) + b"\xff" * 7 + b"\x7f" + len(data).to_bytes(8, "little") + zlib.crc32(data).to_bytes(4, "little")
    body += bytes(4) + len(data).to_bytes(8, "little") + data
    magic, foot = b"\x89MCAP0\r\n", b"\x02" + (20).to_bytes(8, "little") + bytes(20)
    return magic + b"\x06" + len(body).to_bytes(8, "little") + body + foot + magic


READERS: Mapping[str, Reader] = {
    "cell": Reader(
        _cell, ".toml", '[[robot]] [cell] model "1e999mm" = . { } true 1979-05-27 """ \'\'\' # \\u0000 inf _'
    ),
    "program": Reader(_program, ".arps", '.PROGRAM .END IF THEN ELSE FOR TO DO UNTIL CASE VALUE : ; " ( ) [ ] , ^'),
    "locations": Reader(_locations, ".loc", "= , # ; [ ] a.b 1e6 TRANS"),
    "urdf": Reader(_robot, ".urdf", "<link> </robot> <!DOCTYPE &amp; &#0; <![CDATA[ --> name= xmlns: <?xml mimic"),
    "xacro": Reader(_robot, ".xacro", "${ } $(arg $(find <xacro:macro <xacro:if ** * range( [ lambda: x", count=1000),
    "table": Reader(_table, ".csv", ', ; \t " time # e + - x'),
    "layout": Reader(_layout, ".csv", ', ; u v diameter " \r'),
    "metadata": Reader(_metadata, "_metadata.csv", ", type encRes Di Li diff N"),
    "description": Reader(_description, ".toml", "[units] drive = runs [encoder] geometry true 1979-05-27"),
    "sheet": Reader(
        _sheet, ".toml", '[process] [wanted] kind "1e9s" num den lags dead_time 1e300 -1 nan inf', count=2000
    ),
    "drive": Reader(_drive, ".toml", '[motor] [[gear]] preset "1e999V" = . { } true samples U R kM J inf nan -0.0'),
    "recording": Reader(_recording, ".mcap", "zstd lz4 ros2"),
    "chunk": Reader(_recording, ".mcap", "/tf /rosout kind robot cdr", pack=_in_a_chunk),
    "words": Reader(_words, ".json", '{ } [ ] : , "a" null true 1e999 NaN \\ud800'),
    "image": Reader(_image, ".png", "IHDR IDAT PLTE IEND"),
}
"""By name."""
