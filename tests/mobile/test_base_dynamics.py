"""Bases as they are: centre of mass off the origin, wheels that must not slide, rollers at an angle.

Truth is an independent Lagrangian simulation with multipliers, a linear program, and numbers by hand.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog

from holonom.devices import DcMotor, Gear
from holonom.errors import InputError
from holonom.mobile import Wheel, WheelBase, arrangements
from holonom.mobile.drive.coupling import base_acceleration, base_twist, coupling_of, wheel_forces
from holonom.mobile.drive.envelopes import acceleration_envelope, critical_force, force_envelope, speed_envelope
from holonom.mobile.drive.failed_motor import allocation, motors_hold_all, possible_twists
from holonom.mobile.drive.limits import drive_limits
from holonom.mobile.drive.patterns import idle_patterns
from holonom.plots.drive import draw_effective_motors

STRONG = DcMotor(0.1, 0.1e-3, 0.05, 0.05, 1e-6, 48.0, 100.0)
GEAR = Gear(10.0)


def offset_omni(**other: object) -> WheelBase:
    body = {"radius": 0.1, "wheel_radius": 0.03, "mass": 10.0, "com": (0.03, 0.0)} | other
    return arrangements.omni(n=4, **body)  # type: ignore[arg-type]


def offset_differential(com: tuple[float, float] = (0.0, 0.0)) -> WheelBase:
    """base_link 0.2 m ahead of the axle; I = M R^2 / 2 with R^2 = 0.045 m2."""
    wheels = [
        Wheel.at("fixed", -0.2, y, radius=0.05, driven=True, name=name)
        for name, y in (("left", 0.15), ("right", -0.15))
    ]
    front = Wheel.at("castor", 0.1, 0.0, np.pi, radius=0.02, castor_offset=0.02, name="castor")
    return WheelBase([*wheels, front], radius=np.sqrt(0.045), mass=10.0, com=com)


def lagrange(base: WheelBase, forces: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """Acceleration (ax, ay, wd) of the origin by Newton and Euler of the centre of mass, multipliers for wheels.

    Nothing of the package but the wheels' places is used.
    """
    m, (cx, cy), inertia = base.mass or 0.0, base.com, base.alpha * (base.mass or 0.0) * base.radius**2
    v, w = np.array(twist[:2]), twist[2]
    rows, held = [], []
    for wheel in base.wheels:
        along, across = wheel.heading + wheel.roller_angle, wheel.heading + wheel.roller_angle + np.pi / 2
        lever = [wheel.x * np.sin(along) - wheel.y * np.cos(along), wheel.x * np.sin(across) - wheel.y * np.cos(across)]
        if wheel.driven:
            rows.append(np.array([np.cos(along), np.sin(along), lever[0]]) / np.cos(wheel.roller_angle))
        if wheel.kind == "fixed":
            held.append([np.cos(across), np.sin(across), lever[1]])
    D, C = np.array(rows), np.array(held).reshape(-1, 3)
    A = np.zeros((3 + len(C), 3 + len(C)))
    A[:3, :3] = [[m, 0.0, -m * cy], [0.0, m, m * cx], [-m * cy, m * cx, inertia + m * (cx**2 + cy**2)]]
    A[:3, 3:], A[3:, :3] = C.T, C
    b = np.zeros(len(A))
    b[:3] = D.T @ forces + m * w**2 * np.array([cx, cy, 0.0])
    b[3:] = C @ [-w * v[1], w * v[0], 0.0]  # C v' = 0, and a = v' + w x v
    return np.asarray(np.linalg.lstsq(A, b, rcond=None)[0][:3])


def test_a_centre_of_mass_off_the_origin_turns_the_base() -> None:
    """Sideways forces without a torque about the origin: I wd = -M a c, 6 rad/s2 at 1 m/s2 and 30 mm, by hand."""
    base = offset_omni()
    plain = wheel_forces(offset_omni(com=(0.0, 0.0)), [0.0, 1.0, 0.0], 10.0)
    assert base_acceleration(base, plain, 10.0)[2] == pytest.approx(-6.0)
    np.testing.assert_allclose(
        base_acceleration(base, wheel_forces(base, [0.0, 1.0, 0.0], 10.0), 10.0), [0, 1, 0], atol=1e-12
    )
    sideways = acceleration_envelope(base, [np.pi / 2], drive_limits(base, STRONG, GEAR, 0.8)).value[0]
    assert sideways == pytest.approx(4.055, abs=2e-3)


def test_wheels_that_must_not_slide_hold_the_base() -> None:
    """1 N ahead and 1 N back at 0.3 m: 0.3 N m turn 0.225 kg m2 about the origin, and 0.4 more about the axle."""
    base = offset_differential()
    a = base_acceleration(base, [-1.0, 1.0], 10.0)
    assert a[2] == pytest.approx(0.3 / (0.225 + 10.0 * 0.2**2))
    assert a[2] == pytest.approx(0.48, abs=1e-3)
    np.testing.assert_allclose(a[1], 0.2 * a[2])
    assert pytest.approx(1.33, abs=4e-3) == 0.3 / 0.225  # as if it could slide


@given(st.integers(0, 10**6))
def test_forces_and_accelerations_are_those_of_lagrange(seed: int) -> None:
    rng = np.random.default_rng(seed)
    com = tuple(rng.uniform(-0.05, 0.05, 2))
    for base in (
        offset_omni(com=com),
        offset_differential(com),
        arrangements.mecanum(0.3, 0.2, 0.05, mass=9.0, com=com),
    ):
        twist = base.feasible(rng.uniform(-1.0, 1.0, 3))
        f = rng.uniform(-5.0, 5.0, len(base.driven))
        a = lagrange(base, f, twist)
        np.testing.assert_allclose(base_acceleration(base, f, base.mass or 0.0, twist=twist), a, atol=1e-9)
        again = wheel_forces(base, a, base.mass or 0.0, twist=twist)
        np.testing.assert_allclose(lagrange(base, again, twist), a, atol=1e-9)
        assert np.linalg.norm(again) <= np.linalg.norm(f) + 1e-9
        rest = np.array([1.0, 1.0, base.radius]) * lagrange(base, f, np.zeros(3)) * (base.mass or 0.0)
        np.testing.assert_allclose(base.force_coupling @ f, rest, atol=1e-9)


@given(st.integers(0, 10**6))
def test_the_envelope_of_any_base_is_a_linear_program(seed: int) -> None:
    rng = np.random.default_rng(seed)
    base = arrangements.mecanum(0.3, 0.2, 0.05, mass=9.0, com=tuple(rng.uniform(-0.05, 0.05, 2)))
    drive, phi, wd = drive_limits(base, STRONG, GEAR, 0.5), float(rng.uniform(0, 6.3)), float(rng.uniform(-3, 3))
    G = np.stack([lagrange(base, f, np.zeros(3)) for f in np.eye(4)], axis=1)
    along = [-np.cos(phi), -np.sin(phi), 0.0]
    grip = 0.5 * drive.loads / np.sqrt(2.0)
    assert (grip < drive.motor_limits(np.zeros(4))[1]).all()
    found = linprog(
        [0, 0, 0, 0, -1.0], A_eq=np.column_stack([G, along]), b_eq=[0, 0, wd],
        bounds=[*np.column_stack([-grip, grip]), (0, None)],
    )  # fmt: skip
    ours = acceleration_envelope(base, [phi], drive, angular_acceleration=wd)
    assert ours.value[0] == pytest.approx(found.x[-1], rel=1e-7, abs=1e-9)


def test_rollers_push_along_their_axes_only() -> None:
    """20 kg at mu 0.6: mu M g cos 45 ahead with four wheels, mu M g / 2 with the two that push at 45 degrees."""
    base = arrangements.mecanum(0.4, 0.3, 0.05, mass=20.0)
    drive = drive_limits(base, STRONG, GEAR, 0.6)
    ahead, diagonal = critical_force(base, np.radians([0.0, 45.0]), drive).value
    assert ahead == pytest.approx(83.24, abs=5e-3)
    assert diagonal == pytest.approx(58.86, abs=5e-3)
    assert acceleration_envelope(base, [0.0], drive).value[0] == pytest.approx(83.24 / 20.0, abs=1e-3)
    np.testing.assert_allclose(drive.grip(), 0.6 * 49.05 * np.sqrt(0.5))


def test_what_drags_a_wheel_is_no_direction() -> None:
    base = offset_differential()
    drive = drive_limits(base, STRONG, GEAR, 0.6)
    for found in (
        force_envelope(base, np.radians([0.0, 90.0])), acceleration_envelope(base, np.radians([0.0, 90.0]), drive),
        speed_envelope(base, np.radians([0.0, 90.0]), drive),
    ):  # fmt: skip
        np.testing.assert_array_equal(found.reachable & (found.value > 1e-9), [True, False])
        assert np.isfinite(found.value).all()


def test_constraints_hold_in_every_verb_of_a_drive() -> None:
    base = offset_differential()
    C = base.sliding_matrix()
    assert np.abs(C @ base_twist(base, [0.5, 0.7])).max() < 1e-12
    twists = possible_twists(base, blocked=["left"])
    assert twists.shape == (3, 1)
    assert np.abs(C @ twists).max() < 1e-12
    # a force across is taken by the wheels themselves: it asks for no motor but by its lever about the axle
    f = allocation(base) @ np.array([0.0, 1.0, -0.2 / base.radius])
    np.testing.assert_allclose(f, 0.0, atol=1e-12)
    assert idle_patterns(base).shape == (2, 0)
    assert coupling_of(base).motions.shape == (3, 2)


def test_a_ball_has_one_contact_for_three_drives() -> None:
    ball = [Wheel.at("spherical", x, y, radius=0.05, driven=True, name=f"ball {x}") for x, y in ((0.2, 0), (-0.1, 0.1))]
    third = Wheel.at("spherical", -0.1, -0.1, radius=0.05, name="third")
    with pytest.raises(InputError, match=r"drives the ball 'ball 0\.2' three ways"):
        drive_limits(WheelBase([*ball, third], mass=3.0), STRONG, GEAR, 0.5)


def test_two_dead_motors_leave_no_speed_by_direction() -> None:
    """Live wheels 3 and 4 at 225 and 315 deg: by hand they push without a turn along one line only, y."""
    base = arrangements.omni(np.radians([45.0, 135.0, 225.0, 315.0]), radius=0.1, wheel_radius=0.03, mass=5.0)
    drive, phi = drive_limits(base, STRONG, GEAR, 0.6), np.radians(np.arange(0.0, 360.0, 0.5))
    found = speed_envelope(base, phi, drive, out=[0, 1])
    # f3 (-sin 225, cos 225) + f4 (-sin 315, cos 315) with f3 + f4 = 0 has no part along x: sin 225 = sin 315
    np.testing.assert_array_equal(found.reachable, np.abs(np.cos(phi)) < 1e-9)
    np.testing.assert_array_equal(found.reachable, force_envelope(base, phi, out=[0, 1]).value > 1e-9)
    assert found.value.max() < 60.0
    assert np.isfinite(found.value).all()
    assert motors_hold_all(base, 0b0001)
    assert not motors_hold_all(base, 0b0011)


def test_a_figure_leaves_out_what_it_cannot_say() -> None:
    figure = draw_effective_motors(arrangements.omni(n=4, radius=0.1, wheel_radius=0.03), out=[0, 1])
    words = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert words == ["all motors", "without wheel 1 and wheel 2: cannot hold its heading, not drawn"]
