"""The cell file: what it says in SI, that its places are in reach, and every fault with file, line and key."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

from holonom import load_arm
from holonom.app.cell import Cell, cell_schema, load_cell
from holonom.app.console.output import prepare_output
from holonom.errors import CellError, OutputError
from holonom.spatial import pose

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TEXT = (EXAMPLES / "01_sort_coins" / "cell.toml").read_text("utf-8")


def write(folder: Path, text: str) -> Path:
    """A cell file with files of the names that it mentions beside it."""
    for name in ("coins.png", "coins.csv", "sort_coins.arps", "sort_coins.loc"):
        (folder / name).touch()
    path = folder / "cell.toml"
    path.write_text(text, "utf-8")
    return path


def changed(old: str, new: str) -> str:
    assert old in TEXT, "the example no longer says so"
    return TEXT.replace(old, new, 1)


def fault(folder: Path, text: str) -> str:
    path = write(folder, text)
    before = sorted(folder.iterdir())
    with pytest.raises(CellError) as caught:
        load_cell(path)
    assert sorted(folder.iterdir()) == before, "something was written"
    return str(caught.value)


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return load_cell(write(tmp_path, TEXT))


def test_values_are_si(cell: Cell) -> None:
    assert cell.robot[0].home == pytest.approx([0, math.pi / 4, -math.pi, 0, -math.pi / 4, 0])
    assert cell.robot[0].tool.length == 0.12
    assert cell.robot[0].tool.close_time == 0.15
    assert cell.parts is not None
    assert cell.parts.density == 8700.0
    assert cell.robot[0].limits.line_speed == 0.5
    assert cell.robot[0].limits.rotation_speed == pytest.approx(math.pi)
    assert cell.camera is not None
    assert cell.camera.points[1].table == (0.2415, 0.06)
    assert cell.robot[0].pose is None


def test_files_are_beside_the_cell_file_wherever_it_is_read_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, TEXT)
    monkeypatch.chdir(tmp_path.parent)
    cell = load_cell(Path(tmp_path.name) / "cell.toml")
    assert cell.robot[0].program.file.samefile(tmp_path / "sort_coins.arps")
    assert cell.camera is not None
    assert cell.camera.photograph.samefile(tmp_path / "coins.png")


def test_a_cell_does_not_change(cell: Cell) -> None:
    with pytest.raises(ValueError, match="frozen"):
        cell.robot[0].tool.mass = 1.0


@pytest.mark.parametrize("name", ["01_sort_coins", "02_straight_lines"])
def test_examples_load(name: str) -> None:
    assert load_cell(EXAMPLES / name / "cell.toml").robot[0].model.preset == "puma560"


def test_what_the_second_example_leaves_out() -> None:
    cell = load_cell(EXAMPLES / "02_straight_lines" / "cell.toml")
    assert (cell.camera, cell.parts, cell.tray) == (None, None, None)
    assert [law.name for law in cell.robot[0].controllers] == ["cascade", "computed_torque"]


def test_a_pixel_is_half_a_millimetre(cell: Cell) -> None:
    assert cell.camera is not None
    pixels = np.array([point.pixel for point in cell.camera.points])
    table = np.array([point.table for point in cell.camera.points])
    np.testing.assert_allclose(table, [0.2515, 0.242] - 0.5e-3 * pixels[:, ::-1], atol=1e-12)


def test_every_place_and_the_whole_photograph_are_in_reach(cell: Cell) -> None:
    """One and the same branch reaches them all, tool down at any turn, away from the wrist's singularity."""
    assert cell.tray is not None
    points = [(x, y) for x in (0.100, 0.176, 0.2515) for y in (0.050, 0.146, 0.242)]
    for field in cell.tray.fields:
        at = [(i + 0.5, j + 0.5) for i in range(field.columns) for j in range(field.rows)]
        points += [(field.corner[0] + i * field.pitch, field.corner[1] + j * field.pitch) for i, j in at]
    assert len(points) == 9 + 18 + 2 + 4
    arm = load_arm(cell.robot[0].model.preset).with_tool(pose((0, 0, cell.robot[0].tool.length), np.eye(3)))
    targets = [
        pose(np.add(cell.surface[0].pose.position, (x, y, z)), np.array([[c, s, 0], [s, -c, 0], [0, 0, -1]]))
        for x, y in points
        for z in (0.0, 0.05, 0.1, 0.15)
        for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))
    ]
    found = arm.ik(np.array(targets))
    reached = (found.status == 0).all(axis=0)
    assert reached.any(), f"{found.names}: {(found.status == 0).mean(axis=0)}"
    wrist = found.q[:, np.flatnonzero(reached)[0], 4]
    assert np.degrees(np.abs(wrist).min()) > 10
    home = arm.fk(np.array(cell.robot[0].home))
    np.testing.assert_allclose(home[:3, 2], [0, 0, -1], atol=1e-12)


# Old text, new text, the text on whose line the fault lies, its key, and what is said of it.
FAULTS = {
    "misspelt key": ("opening =", "openning =", "openning", "gripper.openning", "no key .*did you mean 'opening'"),
    "misspelt table": ("[gripper]", "[griper]", "[griper]", "griper", "no key .*did you mean 'gripper'"),
    "key in a list": ('"60mm"] }', '"60mm"], x = 1 }', ", x = 1 }", r"camera.points\[1\].x", "there is pixel, table"),
    "key left out": ('mass = "0.4kg"\n', "", "[gripper]", "gripper.mass", "missing; expected: mass with"),
    "table left out": ("[program]\nfile", "[program]\n#", "[program]", "program.file", "missing; expected: ARPS"),
    "unknown preset": ("puma560", "puma650", "puma650", "arm.preset", "no arm preset 'puma650'; there is .*puma560"),
    "unknown controller": (
        '"computed_torque"',
        '"computed_torqe"',
        "computed_torqe",
        r"arm.controllers\[0\]",
        "did you mean 'computed_torque'",
    ),
    "controller twice": ('["comp', '["computed_torque", "comp', "controllers", "arm.controllers", "once"),
    "no list": ('["computed_torque"]', '"cascade"', "controllers", "arm.controllers", "a list in brackets"),
    "joint beyond its limit": ('"-180deg"', '"-230deg"', "home", "arm.home", "-230deg .*-225deg to 45deg"),
    "joint too few": ('"-180deg", ', "", "home", "arm.home", "5 joint angles came; puma560 has 6"),
    "unknown unit": ('"120mm"', '"120furlong"', "120furlong", "gripper.length", "no unit of length 'furlong'; .*mm"),
    "other dimension": ('"120mm"', '"120g"', "120g", "gripper.length", "unit of mass; .*mm, cm, m or um"),
    "no unit": ('"120mm"', "120", "120", "gripper.length", "in mm, cm, m or um"),
    "out of range": ('"0.4kg"', '"-0.4kg"', "-0.4kg", "gripper.mass", "1g to 100kg is allowed"),
    "fraction beyond 1": ("joint_speed = 0.95", "joint_speed = 1.2", "1.2", "limits.joint_speed", "0.01 to 1.0"),
    "text for a number": ("seed = 560", 'seed = "560"', 'seed = "560"', "cell.seed", "a whole number is expected"),
    "negative seed": ("seed = 560", "seed = -560", "seed = -560", "cell.seed", "greater than or equal to 0"),
    "value for a table": ("[parts]", "[[parts]]", "[[parts]]", "parts", "a table is expected"),
    "NaN": ("[364, 20]", "[364, nan]", "nan", r"camera.points\[1\].pixel\[1\]", "finite"),
    "half a pixel": ("[364, 20]", "[364]", "[364]", r"camera.points\[1\].pixel\[1\]", "missing"),
    "pixel of three": ("[364, 20]", "[364, 20, 1]", "[364, 20, 1]", r"camera.points\[1\].pixel", "3 came; 2 are"),
    "no photograph": ("coins.png", "coin.png", "coin.png", "camera.photograph", "no file 'coin.png' in "),
    "no program": ("sort_coins.arps", "sort.arps", "sort.arps", "program.file", "no file 'sort.arps' in "),
    "folder for a file": ('"sort_coins.loc"', '"."', "locations", "program.locations", "no file '.' in "),
    "no such colour": ("#3b82f6", "blue", "blue", r"tray.fields\[0\].colour", "rrggbb"),
    "no columns": (
        "columns = 2",
        "columns = 0",
        "columns = 0",
        r"tray.fields\[1\].columns",
        "greater than or equal to 1",
    ),
    "no diameter": ('"26.4mm"', '"20mm"', '= "20mm"', r"tray.fields\[1\].max_diameter", "above min_diameter, 24.35mm"),
    "same diameters": ('= "26.4mm"\nm', '= "25mm"\nm', "[[tray.fields]]", "tray.fields", "claim the same diam"),
    "same name": ('name = "medium"', 'name = "small"', "[[tray.fields]]", "tray.fields", "its own name"),
    "fields overlap": ('["170mm"', '["150mm"', "[[tray.fields]]", "tray.fields", "'medium' and 'large' overlap"),
    "field beyond the tray": ("columns = 6", "columns = 7", "[[tray.fields]]", "tray.fields", "'small' spans x"),
    "tray beyond the table": ('"212mm"]', '"312mm"]', "[tray]", "tray", "the tray spans y"),
    "part wider than the hand": ('"35mm"\nf', '"30mm"\nf', "[tray]", "tray", "the gripper opens to 30mm"),
    "fingers above the part": ('"1mm"', '"3mm"', 'grasp_height = "3mm"', "parts.grasp_height", "close above"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_fault_names_line_and_key(name: str, tmp_path: Path) -> None:
    old, new, on_line, key, said = FAULTS[name]
    text = changed(old, new)
    line = text[: text.index(on_line)].count("\n") + 1
    message = fault(tmp_path, text)
    place = re.escape(str(tmp_path / "cell.toml"))
    assert re.search(rf"^{place}:{line}: {key}: .*{said}", message, re.MULTILINE), message


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ("[limits]", "[limits", r":\d+:8", "Expected ']'"),
        ('name = "sort coins"', "name = sort coins", r":\d+:8", "Invalid value"),
        ("seed = 560", "seed = 560\nseed = 561", r":\d+:\d+", "Cannot overwrite"),
        ('following_error = "3deg"\n', 'following_error = """3deg', r":\d+", "Unterminated string"),
    ],
)
def test_not_toml(old: str, new: str, place: str, said: str, tmp_path: Path) -> None:
    message = fault(tmp_path, changed(old, new))
    assert re.search(rf"cell\.toml{place}: not TOML: .*{said}", message), message


def test_too_few_calibration_points(tmp_path: Path) -> None:
    points = [line for line in TEXT.splitlines(keepends=True) if line.startswith("  { pixel")]
    text = TEXT
    for point in points[3:]:
        text = text.replace(point, "")
    line = text[: text.index("points =")].count("\n") + 1
    message = fault(tmp_path, text)
    assert f":{line}: camera.points: 3 came; at least 4 are needed" in message
    write(tmp_path, text.replace(points[2], points[2] + points[3]))
    assert load_cell(tmp_path / "cell.toml").camera is not None


def test_camera_without_parts(tmp_path: Path) -> None:
    parts = TEXT[TEXT.index("[parts]") : TEXT.index("# The museum")]
    message = fault(tmp_path, TEXT.replace(parts, ""))
    assert re.search(r"camera: .*add a table \[parts\]", message), message


def test_every_fault_is_told_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = changed("seed = 560", "sed = 560").replace('"120mm"', '"120"').replace('"computed_torque"', '"pid"')
    keys = [line.split(": ")[1] for line in fault(tmp_path, text).splitlines()]
    assert keys == ["cell.sed", "arm.controllers[0]", "gripper.length"]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda path: None, "No such file"),
        (lambda path: path.mkdir(), "Is a directory"),
        (lambda path: path.write_bytes(b"[cell]\n\xff"), ":2: not UTF-8"),
        (lambda path: path.write_bytes(b""), ":1: robot: missing"),
    ],
)
def test_what_is_no_file_of_text(make, said: str, tmp_path: Path) -> None:
    make(tmp_path / "cell.toml")
    with pytest.raises(CellError, match=said):
        load_cell(tmp_path / "cell.toml")


def test_published_schema_is_current() -> None:
    """`holonom doctor --schema > docs/cell.schema.json` brings it up to date."""
    published = EXAMPLES.parent / "docs" / "cell.schema.json"
    assert json.loads(published.read_text("utf-8")) == cell_schema()


def test_schema_describes_every_key() -> None:
    schema = cell_schema()
    for name, table in schema["$defs"].items():
        assert table["additionalProperties"] is False
        for key, value in table["properties"].items():
            assert value.get("description"), f"{name}: {key}"


def test_output_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    folder = prepare_output(tmp_path / "runs" / "one")
    assert folder.is_dir()
    assert list(folder.iterdir()) == []
    assert prepare_output(folder) == folder


def test_output_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "below", Path("/proc/self/nothing")):
        with pytest.raises(OutputError, match=r"cannot write to the output folder .*; give another one with -o"):
            prepare_output(folder)
    assert sorted(tmp_path.iterdir()) == [tmp_path / "file"]
