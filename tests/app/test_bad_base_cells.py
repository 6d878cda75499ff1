"""Cells of bases that cannot be: the line, what came, what is left, before anything runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from holonom.app.console.cli import main

HEAD = '[cell]\nname = "x"\nseed = 1\ntime_limit = "40s"\n[base]\nmass = "{mass}"\n'
CIRCLE = '[path]\nshape = "circle"\nsize = "3m"\nspeed = "0.5m/s"\nacceleration = "0.5m/s2"\n'
PARKING = (
    '[path]\nshape = "reeds_shepp"\nposes = [["0m", "0m", "0deg"], ["0m", "0.8m", "0deg"]]\nradius = "0.6m"\n'
    'speed = "0.5m/s"\nacceleration = "0.5m/s2"\n'
)
WHEEL = '{{ kind = "{}", x = "{}", y = "{}", radius = "80mm", driven = true, name = "{}"{} }}'
CAR = 'arrangement = "ackermann"\nwheelbase = "400mm"\ntrack = "300mm"\nwheel_radius = "50mm"\n'
BICYCLE = 'arrangement = "bicycle"\nwheelbase = "1m"\nwheel_radius = "300mm"\n'


def wheels(*rows: tuple[str, str, str, str, str]) -> str:
    return "wheels = [\n" + ",\n".join(WHEEL.format(*row) for row in rows) + "\n]\n"


BAD = {
    "wheels that contradict each other": (
        wheels(
            ("fixed", "0m", "0.2m", "left", ""),
            ("fixed", "0.3m", "0m", "ahead", ""),
            ("fixed", "0.3m", "0.1m", "skew", ', heading = "40deg"'),
        ),
        CIRCLE,
        r"wheels 'left', 'ahead', 'skew' cannot roll together: .* cannot move; without 'left' it could only turn about",
    ),
    "steering limits that exclude each other": (
        wheels(
            ("steered", "0.3m", "0.2m", "a", ', max_steering = "10deg"'),
            ("steered", "0.3m", "-0.2m", "b", ', max_steering = "10deg", heading = "90deg"'),
            ("fixed", "0m", "0m", "c", ""),
        ),
        CIRCLE,
        r"the steering limits of 'a' \(10 deg\), 'b' \(10 deg\) and what the fixed wheels allow exclude each other",
    ),
    "a radius of zero": (
        CAR.replace('wheel_radius = "50mm"', 'wheel_radius = "0mm"'),
        CIRCLE,
        r"wheel_radius is 0.0; it must be finite and greater than 0 m",
    ),
    "a centre of mass before its wheels": (
        CAR + 'com = ["450mm", "0mm"]\n',
        CIRCLE,
        r"\(450, 0\) mm came; the base tips over at rest",
    ),
    "a centre of mass before a bicycle": (
        BICYCLE + 'com = ["1.1m", "0m"]\n',
        CIRCLE,
        r"\(1100, 0\) mm came; the base tips over at rest",
    ),
    "a centre of mass beside a ball": (
        'arrangement = "sphere"\nwheel_radius = "100mm"\ncom = ["0m", "10mm"]\n',
        CIRCLE,
        r"\(0, 10\) mm came; the base tips over at rest",
    ),
    "a path between what a rover can turn": (
        'arrangement = "rocker6"\nwheelbase = "800mm"\ntrack = "600mm"\nwheel_radius = "100mm"\n',
        CIRCLE.replace("3m", "0.6m"),
        r"it asks for a curve of 0.3 m; the tightest that these wheels drive is 0.531 m",
    ),
    "a path sharper than it can turn": (
        CAR + 'max_steering = "20deg"\n',
        PARKING,
        r"at 3.60 s, at \(0.09, 0.12\) m, it asks for a curve of 0.6 m; the tightest that these wheels drive is 1.25 m",
    ),
}


def checked(tmp_path: Path, text: str, mass: str = "8kg") -> int:
    (tmp_path / "cell.toml").write_text(HEAD.format(mass=mass) + text, "utf-8")
    return main(["check", str(tmp_path / "cell.toml")])


@pytest.mark.parametrize("name", BAD)
def test_it_is_refused(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, path, said = BAD[name]
    assert checked(tmp_path, text + path) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"holonom: error: {tmp_path / 'cell.toml'}:")
    assert re.search(said, error), error


def test_a_negative_mass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert checked(tmp_path, CAR + CIRCLE, mass="-8kg") == 2
    assert "cell.toml:6: base.mass: '-8kg' came; 1g to 5000kg is allowed" in capsys.readouterr().err


def test_a_velocity_that_is_no_number(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    steps = 'velocity = [{ at = "0s", vx = "nanm/s" }, { at = "2s" }]\n'
    assert checked(tmp_path, steps + CAR) == 2
    assert "velocity[0].vx: 'nanm/s' came" in capsys.readouterr().err


@pytest.mark.parametrize("com", ["300mm", "999mm"])
def test_what_is_held_upright_may_lean_aside(com: str, tmp_path: Path) -> None:
    assert checked(tmp_path, 'hold = "2s"\n' + BICYCLE + f'com = ["{com}", "50mm"]\n') == 0


def test_balancing_bases_may_have_their_mass_beside_the_axle(tmp_path: Path) -> None:
    wheels_ = 'arrangement = "segway"\ntrack = "300mm"\nwheel_radius = "80mm"\ncom = ["10mm", "0mm"]\n'
    assert checked(tmp_path, 'hold = "2s"\n' + wheels_) == 0


def test_a_recording_that_tells_nothing_of_the_track(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Straight on: refused by name, with what would help."""
    straight = CIRCLE.replace('"circle"\nsize = "3m"', '"waypoints"\npoints = [["0m", "0m"], ["2m", "0m"]]')
    text = 'arrangement = "differential"\ntrack = "300mm"\nwheel_radius = "50mm"\n'
    (tmp_path / "cell.toml").write_text(HEAD.format(mass="8kg") + text + straight, "utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    assert main(["calibrate", "odometry", str(tmp_path / "out" / "recording.mcap"), "--runs-alone"]) == 2
    assert "wheelbase" in capsys.readouterr().err
