"""Each fault of a cell, with file, line and key."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from cell_files import ABOUT, ALL_KEYS, CELLS, built, write

from holonom.app.cell import load_cell
from holonom.errors import CellError

# Old text, new text, the text on whose line the fault lies, its key, and what is said of it.
FAULTS = {
    "no cell": ('[cell]\nname = "all keys"', '[cel]\nname = "all keys"', "[cel]", "cel", "no key 'cel'; .*'cell'"),
    "robot's name": ('name = "puma"', 'name = "pu ma"', "pu ma", r"robot\[0\].name", "another form is expected"),
    "name of a topic": ('name = "puma"', 'name = "truth"', '"truth"', r"robot\[0\].name", "topics use"),
    "names twice": (
        'name = "cart"',
        'name = "agv"',
        'name = "agv"\nmodel = { arrangement = "mec',
        r"robot\[2\].name",
        "two tables .* are called 'agv'",
    ),
    "no such model": (
        'model = "puma560"',
        'model = "puma650"',
        "puma650",
        r"robot\[0\].model",
        "did you mean 'puma560'",
    ),
    "no such file": (
        'model = "puma560"',
        'model = "puma.urdf"',
        "puma.urdf",
        r"robot\[0\].model.file",
        "no file 'puma",
    ),
    "model of nothing": (
        'model = "puma560"',
        "model = { legs = 4 }",
        "legs",
        r"robot\[0\].model",
        "legs came; a preset",
    ),
    "model of a number": ('model = "puma560"', "model = 4", "model = 4", r"robot\[0\].model", "4 came; a preset"),
    "arrangement": ('arrangement = "omni"', 'arrangement = "omnj"', "omnj", r"robot\[1\].arrangement", "mean 'omni'"),
    "param missing": (
        'radius = "200mm"\n',
        "",
        '[[robot]]\nname = "agv"',
        r"robot\[1\]",
        "radius missing; it needs radius",
    ),
    "param unknown": ('radius = "200mm"', 'raduis = "200mm"', "raduis", r"robot\[1\].raduis", "did you mean 'radius'"),
    "param's unit": ('radius = "200mm"', 'radius = "200kg"', "200kg", r"robot\[1\].radius", "unit of mass"),
    "no mass": ('mass = "12kg"\n', "", '[[robot]]\nname = "agv"', r"robot\[1\].mass", "missing; expected: mass with"),
    "names of wheels": (
        'wheels = ["a", "b", "c"]',
        'wheels = ["a", "b"]',
        'wheels = ["a"',
        r"robot\[1\].wheels",
        "2 names of wheels came; 3 different",
    ),
    "wheel of a list": (
        'kind = "castor", x',
        'kind = "caster", x',
        "caster",
        r"robot\[3\].wheels\[2\].kind",
        "did you mean 'castor'",
    ),
    "drives": ('drives = "from_limits"', 'drives = "from_limit"', "from_limit", r"robot\[2\].drives", "'from_limits'"),
    "drive's key": ('supply = "24V"', 'suply = "24V"', "suply", r"robot\[1\].drives.suply", "did you mean 'supply'"),
    "pose of five": ('"10deg", "20deg", "30deg"]', '"10deg", "20deg"]', "10deg", r"robot\[0\].pose", "5 numbers came"),
    "pose's unit": (
        '"10deg", "20deg", "30deg"]',
        '"10deg", "20mm", "30deg"]',
        "10deg",
        r"robot\[0\].pose\[4\]",
        "unit of length",
    ),
    "base in the air": (
        '["-3m", "1m", "0m",',
        '["-3m", "1m", "1m",',
        '["-3m"',
        r"robot\[2\].pose",
        "level on the floor",
    ),
    "home of a base": ('hold = "3s"', 'hold = "3s"\nhome = []', "home = []", r"robot\[3\].home", "a base has none"),
    "home's limit": ('"45deg", "-180deg"', '"45deg", "-230deg"', "-230deg", r"robot\[0\].home", "-225deg to 45deg"),
    "home's unit": ('"45deg", "-180deg"', '"45deg", "-180mm"', "-180mm", r"robot\[0\].home\[2\]", "unit of length"),
    "controller": ('"cascade"', '"cascad"', '"cascad"', r"robot\[0\].controllers\[0\]", "did you mean 'cascade'"),
    "controller's key": (
        'law_bandwidth = "8rad/s"',
        'bandwidth = "30rad/s"',
        "bandwidth",
        r"robot\[0\].controllers\[1\].bandwidth",
        "law_bandwidth",
    ),
    "part of a base": (
        "traction_control = false",
        "traction = false",
        "traction",
        r"robot\[1\].controllers.traction",
        "did you mean 'traction_control'",
    ),
    "tool": ('kind = "gripper"', 'kind = "griper"', "griper", r"robot\[0\].tool.kind", "did you mean 'gripper'"),
    "tool's key": ('opening = "50mm"', 'opening = "50s"', "50s", r"robot\[0\].tool.opening", "unit of time"),
    "limits of a base": (
        'turn_rate = "90deg/s"',
        'turn_speed = "90deg/s"',
        "turn_speed",
        r"robot\[1\].limits.turn_speed",
        "no key 'turn_speed'; there is acceleration, dead_band, jerk, side_acceleration, ",
    ),
    "levels": (
        'interpolation = "cubic"',
        'interpolation = "cubik"',
        "cubik",
        r"robot\[0\].levels.interpolation",
        "did you mean 'cubic'",
    ),
    "start twice": (
        'start = "2s"',
        'start = { time = "2s", signal = 7 }',
        "start = { time",
        r"robot\[1\].start",
        "one of the two",
    ),
    "tilted obstacle": (
        'pose = ["3m", "3m", "200mm", "0deg", "0deg", "0deg"]',
        'pose = ["3m", "3m", "200mm", "0deg", "9deg", "0deg"]',
        "[[obstacle]]",
        r"obstacle\[0\]",
        "it stands upright",
    ),
    "time-out": (
        'timeout = "0.5s"',
        'timeout = "1ms"',
        'timeout = "1ms"',
        r"robot\[2\].limits.timeout",
        "20ms to 1440min is allowed",
    ),
    "levels of a base": (
        'levels = { supervisor = "50ms", interpolation = "hold" }',
        'levels = { supervisor = "50ms", servo = "2ms" }',
        'servo = "2ms"',
        r"robot\[1\].levels.servo",
        "a base's levels are supervisor and interpolation",
    ),
    "levels without a path": (
        'hold = "3s"',
        'hold = "3s"\nlevels = { supervisor = "50ms" }',
        'levels = { supervisor = "50ms" }',
        r"robot\[3\].levels",
        "give it a path",
    ),
    "program": (
        'file = "wave.arps"',
        'file = "waves.arps"',
        "waves",
        r"robot\[0\].program.file",
        "no file 'waves.arps'",
    ),
    "program of a base": (
        'hold = "3s"',
        'program = "wave.arps"',
        "program = ",
        r"robot\[3\].program",
        "a base has none",
    ),
    "done of an arm": (
        "[robot.program]",
        "done = 3\n[robot.program]",
        "done = 3",
        r"robot\[0\].done",
        "an arm has none; give it a program",
    ),
    "two tasks": (
        'hold = "3s"',
        'hold = "3s"\nvelocity = [{ at = "0s" }]',
        'hold = "3s"',
        r"robot\[3\].hold",
        "velocity and hold came",
    ),
    "path": ('shape = "circle"', 'shape = "circel"', "circel", r"robot\[1\].path.shape", "'circle'"),
    "velocity's order": ('{ at = "2s" }', '{ at = "0s" }', "velocity", r"robot\[2\].velocity", "later than the one"),
    "start": ("start = { signal = 7 }", "start = { signal = 0 }", "signal = 0", r"robot\[2\].start.signal", "0 came"),
    "sensor's kind": ('kind = "gyro"', 'kind = "gyroo"', "gyroo", r"sensor\[0\].kind", "did you mean 'gyro'"),
    "sensor's param": ('noise = "0.1deg/s"', 'noise = "0.1deg"', '"0.1deg"', r"sensor\[0\].noise", "unit of angle"),
    "sensor of nobody": (
        'robot = "agv"\nname = "compass"',
        'robot = "agw"\nname = "compass"',
        "agw",
        r"sensor\[0\].robot",
        "did you mean 'agv'",
    ),
    "sensor of any": (
        'robot = "agv"\nname = "compass"',
        'name = "compass"',
        "[[sensor]]",
        r"sensor\[0\].robot",
        "several robots",
    ),
    "obstacle": ('size = ["200mm", "300mm", "400mm"]\n', "", "[[obstacle]]", r"obstacle\[0\]", "needs size, or radius"),
    "surface": (
        '["400mm", "-100mm", "300mm", "0deg"',
        '["400mm", "-100mm", "300mm", "5deg"',
        '"5deg"',
        r"surface\[0\].pose",
        "is level",
    ),
    "part": ('radius = "20mm"\nthick', "radius = 20\nthick", "radius = 20\n", r"part\[0\].radius", "20 came"),
    "patch": ('radius = "300mm"\n', "", "[[patch]]", r"patch\[0\]", "needs radius or size"),
    "fault's robot": (
        'robot = "agv"\nkind',
        'robot = "puma"\nkind',
        'robot = "puma"\nkind',
        r"fault\[0\].robot",
        "is an arm",
    ),
    "fault's wheel": ('wheel = "b"', 'wheel = "d"', 'wheel = "d"', r"fault\[0\].wheel", "no driven wheel 'd'"),
    "event's signal": ("signal = 3\n", 'signal = "3"\n', 'signal = "3"', r"event\[0\].signal", "a whole number"),
    "tray": ('size = ["200mm", "200mm"]', 'size = ["700mm", "200mm"]', "[tray]", "tray", "the tray spans x"),
    "short beside long": (
        "[floor]",
        '[gripper]\nlength = "1m"\n[floor]',
        "[gripper]",
        "gripper",
        r"table \[gripper\] came, .* 'tool'",
    ),
    "arm beside robots": (
        "[floor]",
        '[arm]\npreset = "puma560"\n[floor]',
        "[arm]",
        "arm",
        r"tables \[arm\] and \[\[robot\]\]",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_fault_names_line_and_key(name: str, tmp_path: Path) -> None:
    old, new, on_line, key, said = FAULTS[name]
    assert old in ALL_KEYS, "the cell no longer says so"
    text = ALL_KEYS.replace(old, new, 1)
    line = text[: text.index(on_line)].count("\n") + 1
    with pytest.raises(CellError) as caught:
        load_cell(write(tmp_path, text))
    place = re.escape(str(tmp_path / "cell.toml"))
    wanted = rf"^{place}:{line}: {key}: .*{said}"
    assert re.search(wanted, str(caught.value), re.MULTILINE), caught.value


@pytest.mark.parametrize(
    ("on", "said"),
    [
        ("agw.top", r"no robot 'agw'; there is agv; did you mean 'agv'\?"),
        ("agv.topp", r"no frame of 'agv' 'topp'; there is base_link, top; did you mean 'top'\?"),
        ("ur.top", "a robot cannot stand on itself"),
        ("agv top", "another form is expected"),
    ],
)
def test_what_nothing_can_stand_on(on: str, said: str, tmp_path: Path) -> None:
    text = (CELLS / "arm_on_base.toml").read_text("utf-8").replace("arm_on_base.arps", "wave.arps")
    with pytest.raises(CellError, match=rf"cell.toml:\d+: robot\[1\].on: .*{said}"):
        load_cell(write(tmp_path, text.replace("agv.top", on)))


def test_an_arm_cannot_stand_on_an_arm_nor_a_base_on_anything(tmp_path: Path) -> None:
    robots = '[[robot]]\nname = "a"\nmodel = "ur5e"\non = "b"\n[[robot]]\nname = "b"\nmodel = "panda"\non = "a"\n'
    with pytest.raises(CellError) as caught:
        load_cell(write(tmp_path, ABOUT + robots))
    assert [line.split(": ")[1] for line in str(caught.value).splitlines()] == ["robot[0].on", "robot[1].on"]
    assert "'b' is an arm; a robot stands on a base" in str(caught.value)
    text = (CELLS / "six_bases.toml").read_text("utf-8").replace("done = 1\n", 'done = 1\non = "diff_2.top"\n')
    with pytest.raises(CellError, match=r"robot\[0\].on: it came; a base stands on the floor"):
        load_cell(write(tmp_path, text))


@pytest.mark.parametrize(
    ("old", "new", "place", "said"),
    [
        ('entry = "wave"', 'entry = "weave"', r"robot\[0\].program.entry", "weave"),
        ('"-100mm", "300mm"', '"-100mm", "700mm"', r"robot\[0\].home", "tool begins 131 mm below the surface"),
        ('limits = { speed = "1m/s"', 'limits = { speed = "0.5m/s"', r"robot\[1\].limits.speed", "path asks for 0.8"),
        ("start = { signal = 7 }", "start = { signal = 8 }", r"robot\[2\].start", "waits for signal 8, which no"),
        ("done = 7", "done = 9", r"robot\[2\].start", "waits for signal 7, which no"),
        ('hold = "3s"', 'hold = "70s"', r"cell.time_limit", "the hold of own takes until 70.0 s"),
        ('{ at = "2s" }]', '{ at = "2min" }]', r"cell.time_limit", "the velocity of cart takes until 120.0 s"),
        ('law_bandwidth = "8rad/s"', 'law_bandwidth = "11rad/s"', r"robot\[0\].controllers", "at most 10 rad/s there"),
        ('"10ms", servo = "1ms"', '"12ms", servo = "4ms"', r"robot\[0\].levels.servo", "period is 4 ms"),
        ('"50ms", inter', '"50.2ms", inter', r"robot\[1\].levels", "supervisor is 0.0502 s"),
        ('delay = "2ms"', 'delay = "20ms"', r"robot\[0\].levels", "delay is 0.02 s"),
        ('time_limit = "60s"', 'time_limit = "5s"', r"cell.time_limit", "the path of agv takes until"),
        (
            'robot = "agv"\nname = "compass"',
            'robot = "puma"\nname = "compass"',
            r"sensor\[0\].kind",
            "no read\\(truth, rng\\)",
        ),
        (
            'pose = { position = ["1m", "0m", "0m"]',
            'pose = { position = ["2m", "0m", "0m"]',
            r"robot\[1\].pose",
            "begins at",
        ),
    ],
)
def test_what_only_building_finds(old: str, new: str, place: str, said: str, tmp_path: Path) -> None:
    assert old in ALL_KEYS
    with pytest.raises(CellError, match=rf"cell.toml:\d+: {place}: .*{said}"):
        built(write(tmp_path, ALL_KEYS.replace(old, new, 1)))
