"""Published numbers of the arrangements: WPILib, Rojas' coupling of a four-wheel robot, a mecanum example."""

import json
import math

import numpy as np
import pytest
from bases import presets

from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import ARRANGEMENTS, arrangement
from holonom.mobile import arrangements as arr
from holonom.mobile.base import WheelBase
from holonom.mobile.base.centre import centre_of_axles

SQUARE = {"wheelbase": 24.0, "track": 24.0, "wheel_radius": 1.0}  # WPILib's wheels at (+-12, +-12) m


@pytest.fixture(scope="module")
def cases(data_folder):
    return json.loads((data_folder / "omni" / "omni_cases.json").read_text())


def printed(value, shown):
    """Whether a value, rounded as far as `shown` is printed, is what is shown."""
    digits = len(repr(shown).partition(".")[2]) if isinstance(shown, float) else 0
    return abs(value - shown) <= 0.5 * 10.0**-digits + 1e-9


def test_wpilib_mecanum(cases):
    published = cases["wpilib_mecanum"]
    base = arr.mecanum(**SQUARE)
    for case in published["inverse"]:
        speeds = base.wheel_speeds(case["v"])
        assert all(printed(a, b) for a, b in zip(speeds, case["w"], strict=True)), (case, speeds)
        vx, vy, w = case["v"]
        exact = [vx - vy - 24 * w, vx + vy + 24 * w, vx + vy - 24 * w, vx - vy + 24 * w]
        np.testing.assert_allclose(speeds, exact, rtol=1e-12, atol=1e-12)
    for case in published["forward"]:
        fl, fr, rl, rr = case["w"]
        exact = [(fl + fr + rl + rr) / 4, (-fl + fr + rl - rr) / 4, (-fl + fr - rl + rr) / 96]
        np.testing.assert_allclose(base.twist(case["w"]), exact, atol=1e-12)
        np.testing.assert_allclose(base.twist(case["w"]), case["v"], atol=1e-3)  # their wheel speeds are rounded
    d = published["desaturate"]
    np.testing.assert_allclose(base.desaturate(d["w"], d["max"]), np.array(d["w"]) * d["factor"], rtol=1e-15)


def test_wpilib_swerve(cases):
    published = cases["wpilib_swerve"]
    base = arr.swerve(**SQUARE)
    for case in published["inverse"]:
        speeds, angles = base.wheel_speeds(case["v"]), base.steering(case["v"])
        np.testing.assert_allclose(speeds, case["speed"], atol=0.5e-2)
        np.testing.assert_allclose(np.degrees(angles), case["angle_deg"], atol=1e-9)
    for case in published["forward"]:
        angles = np.radians(case["angle_deg"])
        speeds = np.array(case["speed"])
        found = base.twist(speeds, angles)
        np.testing.assert_allclose(found, case["v"], atol=0.01)  # printed with two to four digits
        A = np.array([[1, 0, -y, 0, 1, x] for x, y in [(12, 12), (12, -12), (-12, 12), (-12, -12)]]).reshape(8, 3)
        b = np.stack([speeds * np.cos(angles), speeds * np.sin(angles)], axis=1).reshape(8)
        np.testing.assert_allclose(found, np.linalg.lstsq(A, b, rcond=None)[0], atol=1e-11)


def test_wpilib_optimises_like_this():
    """`SwerveModuleState::Optimize`: a wheel at 0 asked for 135 deg forwards goes to -45 deg backwards."""
    base = arr.swerve([[0.0, 0.3], [0.0, -0.3]], wheel_radius=0.1)
    v = [math.cos(math.radians(135)), math.sin(math.radians(135)), 0.0]
    np.testing.assert_allclose(np.degrees(base.steering(v, [0.0, np.pi])), [-45.0, 135.0])
    np.testing.assert_allclose(base.wheel_speeds(v, base.steering(v, [0.0, np.pi])), [-10.0, 10.0])


def test_coupling_of_a_soccer_robot(cases):
    """Rojas' wheels, 33 deg in front and 45 deg behind; his vector is (right, forwards, R w), and w to the left."""
    example = cases["ssl_coupling"]["example_33_45"]
    phi, theta = math.radians(example["phi_deg"]), math.radians(example["theta_deg"])
    angles = [phi - math.pi / 2, math.pi / 2 - phi, math.pi / 2 + theta, -math.pi / 2 - theta]
    base = arr.omni(angles, radius=0.08, wheel_radius=0.027)
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # (right, forwards, .) from (x, y, .)
    np.testing.assert_allclose(base.velocity_coupling @ turned.T, example["D"], atol=1e-12)
    np.testing.assert_allclose(turned @ base.velocity_coupling_inverse, example["pinv"], atol=1e-12)
    right, forwards = base.wheel_speeds([0.0, -1.0, 0.0]), base.wheel_speeds([1.0, 0.0, 0.0])
    assert (right[:2] < 0).all()
    assert (right[2:] > 0).all()
    assert (np.sign(forwards) == [1, -1, -1, 1]).all()
    np.testing.assert_allclose(base.wheel_speeds([0.0, 0.0, 1.0]) * 0.027, 0.08, atol=1e-15)


def test_published_three_wheel_and_mecanum_matrices(cases):
    """OptiOdom's omni robot (motor axes at -60, 60, 180 deg turned the other way) and mecanum matrix; robomech_ws."""
    published = cases["optiodom"]
    three = np.array(published["omni3_body_from_wheels_L1"])
    base = arr.omni(np.radians([-60.0, 60.0, 180.0]), radius=1.0, wheel_radius=1.0)
    np.testing.assert_allclose(np.abs(base.velocity_coupling_inverse), np.abs(three), atol=1e-12)
    four = arr.mecanum(0.2, 0.2, 1.0)
    np.testing.assert_allclose(four.twist(np.diag([1.0, -1.0, 1.0, -1.0])).T[0], [0.25, -0.25, 0.25, -0.25])
    example = cases["mecanum_example"]
    base = arr.mecanum(2 * example["a"], 2 * example["b"], example["R"])
    np.testing.assert_allclose(base.twist(example["w_rad_s"]), example["result"], atol=1e-12)


def test_differential_drive_by_hand():
    base = arr.differential(0.4, (0.1, 0.12))
    left, right = 3.0, 5.0
    vl, vr = 0.1 * left, 0.12 * right
    np.testing.assert_allclose(base.twist([left, right]), [(vl + vr) / 2, 0.0, (vr - vl) / 0.4], atol=1e-15)
    assert base.driven == ("left", "right")


def test_car_and_tricycle_by_hand():
    L, t, delta = 2.5, 1.5, 0.4
    car = arr.ackermann(L, t, 0.3)
    rho = L / math.tan(delta)
    expected = [math.atan(L / (rho - t / 2)), math.atan(L / (rho + t / 2))]
    np.testing.assert_allclose(arr.ackermann_steering(car, delta), expected, atol=1e-12)
    np.testing.assert_allclose(arr.ackermann_steering(car, [0.0, -delta])[1], [-expected[1], -expected[0]], atol=1e-12)
    tri = arr.tricycle(1.2, 0.8, 0.15)
    v, w = 0.15 * 4.0 * math.cos(0.5), 0.15 * 4.0 * math.sin(0.5) / 1.2
    np.testing.assert_allclose(tri.twist([4.0], [0.5]), [v, 0.0, w], atol=1e-12)


def test_sphere_and_synchro_by_hand():
    np.testing.assert_allclose(arr.sphere(0.1).wheel_speeds([0.2, -0.3, 0.0]), [2.0, -3.0])
    with pytest.raises(InputError, match="ball"):
        arr.sphere(0.1).wheel_speeds([0.2, -0.3, 0.5])  # the floor holds it
    synchro = arr.synchro(0.3, 0.05, n=4)
    np.testing.assert_allclose(
        synchro.twist([1.0] * 4, [0.7]), 0.05 * np.array([np.cos(0.7), np.sin(0.7), 0]), atol=1e-12
    )


@pytest.mark.parametrize("n", [3, 4, 5, 8])
def test_even_omni_bases_are_even(n):
    D = arr.omni(n=n, radius=0.2, wheel_radius=0.05).velocity_coupling
    np.testing.assert_allclose(D.T @ D, np.diag([n / 2, n / 2, n]), atol=1e-12)
    assert abs(D[0, 0] + D[-1, 0]) < 1e-12  # x lies midway between two wheels


@pytest.mark.parametrize("kind", sorted(ARRANGEMENTS))
def test_every_arrangement_drives_forwards(kind):
    """Conformance: any preset takes the body's numbers, goes forwards, and knows it from its wheels."""
    plain = {
        "differential": {"track": 0.3}, "tricycle": {"wheelbase": 1.0, "track": 0.6},
        "ackermann": {"wheelbase": 1.0, "track": 0.6}, "synchro": {"radius": 0.2}, "omni": {"n": 3, "radius": 0.2},
        "mecanum": {"wheelbase": 0.4, "track": 0.3}, "swerve": {"wheelbase": 0.4, "track": 0.3}, "sphere": {},
        "bicycle": {"wheelbase": 1.0}, "dual_ackermann": {"wheelbase": 0.5, "track": 0.4}, "segway": {"track": 0.4},
        "skid_steer": {"wheelbase": 0.3, "track": 0.3}, "rocker6": {"wheelbase": 0.8, "track": 0.6},
    }  # fmt: skip
    base = arrangement(kind)(**plain[kind], wheel_radius=0.05, mass=5.0, alpha=0.7, com=(0.1, 0.0), com_height=0.2)
    assert isinstance(base, WheelBase)
    assert (base.name, base.mass, base.alpha, base.com_height) == (kind, 5.0, 0.7, 0.2)
    v = [0.5, 0.0, 0.0]
    steering = base.steering(v)
    np.testing.assert_allclose(base.twist(base.wheel_speeds(v), steering), v, atol=1e-12)
    with pytest.raises(ModelError, match="above zero"):
        arrangement(kind)(**plain[kind], wheel_radius=0.0)
    for length in plain[kind]:
        if length != "n":
            with pytest.raises(ModelError, match="number above zero"):
                arrangement(kind)(**(plain[kind] | {length: 0.0}), wheel_radius=0.05)
    with pytest.raises(TypeError, match="masss"):
        arrangement(kind)(**plain[kind], wheel_radius=0.05, masss=5.0)


def test_names_of_presets_cover_the_table():
    assert {b.name for b in presets().values()} == set(ARRANGEMENTS)
    with pytest.raises(UnknownName, match="did you mean 'swerve'"):
        arrangement("swerv")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: arr.omni(radius=0.2, wheel_radius=0.05), "either angles="),
        (lambda: arr.omni([0.0, 1.0, 2.0], n=3, radius=0.2, wheel_radius=0.05), "either angles="),
        (lambda: arr.omni(n=1, radius=0.2, wheel_radius=0.05), "whole number from 2"),
        (lambda: arr.swerve(wheel_radius=0.1), "either positions="),
        (lambda: arr.swerve(wheelbase=0.3, wheel_radius=0.1), "either positions="),
        (lambda: arr.swerve([[0.0, 0.1], [0.2, 0.0]], wheelbase=0.5, wheel_radius=0.1), "either positions="),
        (lambda: arr.swerve([[0.0, 0.1], [0.2, 0.0]], wheelbase=0.5, track=0.4, wheel_radius=0.1), "either positions="),
        (lambda: arr.sphere(True), "radius = True"),
        (lambda: arr.omni(n=3, radius=True, wheel_radius=0.05), "radius True"),
        (lambda: arr.mecanum(0.4, 0.3, 0.05, mass=True), "mass True"),
        (lambda: arr.mecanum(0.4, 0.3, 0.05, com_height="high"), "com_height 'high'"),
        (lambda: arr.tricycle(1.2, 0.8, 0.1, max_steering="1"), "max_steering '1'"),
        (lambda: arr.swerve([[0.0, 0.1], [0.2, 0.0]], wheel_radius=0.1, names=["a"]), "2 wheels and 1 names"),
        (lambda: arr.differential(math.nan, 0.1), "track nan"),
        (lambda: arr.differential("0.3", 0.1), "track '0.3'"),
        (lambda: arr.differential(0.3, (0.1, 0.1, 0.1)), "3 wheel radii"),
        (lambda: arr.synchro(0.3, 0.1, n=2.5), "n = 2.5"),
        (lambda: arr.mecanum(0.4, 0.3, "0.05"), "radius = '0.05'"),
    ],
)
def test_what_is_no_arrangement_is_refused(make, words):
    with pytest.raises(ModelError) as problem:
        make()
    assert words in str(problem.value)


def test_arrays_of_presets_are_checked():
    with pytest.raises(ShapeError, match="angles"):
        arr.omni([0.0, np.nan, 1.0], radius=0.1, wheel_radius=0.1)
    with pytest.raises(ShapeError, match="positions"):
        arr.swerve([[0.0, 0.1, 0.2]], wheel_radius=0.1)
    with pytest.raises(ShapeError, match="wheel_radius holds nan"):
        arr.differential(0.3, (0.1, math.nan))
    with pytest.raises(ShapeError, match="angles holds something that is not a number"):
        arr.omni(["a", 1, 2], radius=0.1, wheel_radius=0.1)
    with pytest.raises(ShapeError, match=r"angles has shape \(1, 3\)"):
        arr.omni([[0.0, 2.0, 4.0]], radius=0.1, wheel_radius=0.1)
    with pytest.raises(ShapeError, match=r"castor has shape \(1,\)"):
        arr.differential(0.3, 0.1, castor=(1.0,))
    with pytest.raises(ShapeError, match="bicycle holds nan"):
        arr.ackermann_steering(arr.ackermann(2.0, 1.0, 0.3), np.nan)
    with pytest.raises(InputError, match="no steered wheel"):
        arr.ackermann_steering(arr.mecanum(0.4, 0.3, 0.05), 0.1)


@pytest.mark.parametrize("angle", [math.pi / 2, 3.0, -math.pi / 2])
def test_a_bicycle_that_cannot_roll_is_refused(angle):
    with pytest.raises(OutOfLimits, match=rf"bicycle is {angle:.6g} rad; an angle between -pi/2 and pi/2"):
        arr.ackermann_steering(arr.ackermann(2.5, 1.5, 0.3), [0.1, angle])


def test_a_sharp_turn_of_a_car_keeps_one_centre():
    car = arr.ackermann(2.5, 1.5, 0.3)
    for angle in (1.2, 1.5):  # before and beyond atan(2 L / t), where the centre passes the inner rear wheel
        found = centre_of_axles(car, arr.ackermann_steering(car, angle))
        np.testing.assert_allclose(found.point, [0.0, 2.5 / math.tan(angle)], atol=1e-9)
        assert found.miss < 1e-9
