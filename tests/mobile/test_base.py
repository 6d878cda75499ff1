"""Laws of inverse and forward model on any base; compiled against float form; bad input."""

import math

import numpy as np
import pytest
from bases import any_base, axled_bases, omni_bases, presets, steered_bases, twists
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base import WheelBase
from holonom.mobile.base.centre import centre_of_axles
from holonom.mobile.base.wheel import Wheel

BASES = presets()


def velocity_at(twist, x, y):
    return np.array([twist[0] - twist[2] * y, twist[1] + twist[2] * x])


@given(omni_bases(), twists)
def test_couplings_of_omni_bases(base, v):
    D, C = base.velocity_coupling, base.force_coupling
    R, alpha = base.radius, base.alpha
    np.testing.assert_allclose(base.velocity_coupling_inverse @ D, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(np.diag([1.0, 1.0, alpha]) @ C, D.T, atol=1e-12)  # D = C_1^T
    np.testing.assert_allclose(C @ base.force_coupling_inverse, np.eye(3), atol=1e-9)
    f = np.cos(np.arange(len(base.driven)))
    F = D.T @ f  # Fx, Fy, torque / R
    body = v * [1.0, 1.0, R]
    np.testing.assert_allclose(f @ (D @ body), F @ body, atol=1e-9)  # power balance
    np.testing.assert_allclose(base.wheel_speeds(v) * base.wheel_radii, D @ body, atol=1e-9)


@given(axled_bases(), twists)
def test_power_balance_with_constrained_wheels(base, v):
    """Rim forces and axle forces on the body do the work that the rims do: sliding rows do none."""
    xi = base.feasible(v)
    speeds = base.wheel_speeds(xi)
    force = np.sin(1.0 + np.arange(len(speeds)))
    total = np.zeros(3)
    for wheel, f in zip((w for w in base.wheels if w.driven), force, strict=True):
        fx, fy = f * math.cos(wheel.heading), f * math.sin(wheel.heading)
        total += [fx, fy, wheel.x * fy - wheel.y * fx]
    np.testing.assert_allclose(force @ (speeds * base.wheel_radii), total @ xi, atol=1e-9)


@given(any_base(), twists)
def test_forward_after_inverse_is_identity(base, v):
    xi = base.feasible(v)
    steering = base.steering(xi)
    speeds = base.wheel_speeds(xi, steering)
    np.testing.assert_allclose(base.wheel_speeds(xi), speeds, atol=1e-9 * (1 + np.abs(speeds).max()))
    np.testing.assert_allclose(base.twist(speeds, steering), xi, atol=1e-8)
    np.testing.assert_allclose(base.residual(speeds, steering), 0.0, atol=1e-8)
    np.testing.assert_allclose(base.sliding(xi, steering), 0.0, atol=1e-9)


@given(any_base(), twists)
def test_rolling_rows_are_the_velocity_of_the_contact(base, v):
    v = v if base.steered else base.feasible(v)
    steering = base.steering(v)
    headings = {w.name: w.heading for w in base.wheels}
    for name, angle in zip(base.steered, steering, strict=True):
        headings[name] += angle
    expected = []
    for w in base.wheels:
        if w.driven and w.kind in ("fixed", "steered"):
            ahead = np.array([math.cos(headings[w.name]), math.sin(headings[w.name])])
            expected.append(ahead @ velocity_at(v, w.x, w.y) / w.radius)
    if expected:
        np.testing.assert_allclose(base.wheel_speeds(v, steering), expected, atol=1e-8)


@given(omni_bases(), st.integers(0, 1000))
def test_the_forward_model_is_the_least_squares_fit(base, seed):
    speeds = np.random.default_rng(seed).normal(size=len(base.driven))
    A = base.rolling_matrix()
    xi = np.linalg.lstsq(A, speeds * base.wheel_radii, rcond=None)[0]
    np.testing.assert_allclose(base.twist(speeds), xi, atol=1e-8)
    np.testing.assert_allclose(base.residual(speeds), speeds * base.wheel_radii - A @ xi, atol=1e-8)


@given(steered_bases(), st.integers(0, 1000))
def test_the_traced_normal_equations_are_the_least_squares_fit(base, seed):
    """Of modules: a wheel that steers and drives measures the whole velocity of its contact, as WPILib has it."""
    assume(all(w.driven for w in base.wheels if w.kind == "steered"))
    rng = np.random.default_rng(seed)
    speeds, steering = rng.normal(size=len(base.driven)), rng.uniform(-3, 3, len(base.steered))
    driven = [n in base.driven for n in base.rolling_names]
    A = np.concatenate([base.rolling_matrix(steering)[driven], base.sliding_matrix(steering)])
    right = np.concatenate([speeds * base.wheel_radii, np.zeros(len(A) - len(speeds))])
    scale = np.array([1.0, 1.0, 1.0 / base.radius])
    assume(np.linalg.cond(A * scale) < 1e3)
    xi = scale * np.linalg.lstsq(A * scale, right, rcond=None)[0]
    np.testing.assert_allclose(base.twist(speeds, steering), xi, atol=1e-7)


@given(any_base(), twists, twists)
def test_feasible_is_the_nearest_that_drags_nothing(base, v, other):
    scale = np.array([1.0, 1.0, base.radius])
    near = base.feasible(v)
    np.testing.assert_allclose(base.feasible(near), near, atol=1e-8)
    if not base.steered:
        np.testing.assert_allclose(base.sliding(near), 0.0, atol=1e-8)
        rival = base.feasible(other)
        assert np.linalg.norm((v - near) * scale) <= np.linalg.norm((v - rival) * scale) + 1e-9
    else:
        np.testing.assert_allclose(near, v, atol=1e-9)  # wheels that all steer alone follow anything


@given(steered_bases(), twists, st.integers(0, 1000))
def test_steering_stays_near_and_passes_through_the_centre(base, v, seed):
    current = np.random.default_rng(seed).uniform(-20, 20, len(base.steered))
    assume(min(np.linalg.norm(velocity_at(v, w.x, w.y)) for w in base.wheels) > 1e-3)
    angles = base.steering(v, current)
    assert np.all(np.abs(angles - current) <= np.pi / 2 + 1e-9)
    straight = base.steering(v)
    half_turns = (angles - straight) / np.pi
    np.testing.assert_allclose(half_turns, np.round(half_turns), atol=1e-7)
    apart = np.linalg.svd(base.sliding_matrix(angles)[:, :2], compute_uv=False)[-1] > 1e-3
    if abs(v[2]) > 0.05 and apart:  # axles that lie in one line leave the centre open
        found = centre_of_axles(base, angles)
        np.testing.assert_allclose(found.point, [-v[1] / v[2], v[0] / v[2]], atol=1e-5)
        assert found.miss < 1e-6
    driven = [n in base.driven for n in base.steered]
    along = base.wheel_speeds(v) * base.wheel_radii
    assert np.all(along >= 0.0)  # heading where they roll
    flipped = np.where(np.abs(np.round(half_turns)) % 2 == 1, -1.0, 1.0)[driven]
    np.testing.assert_allclose(base.wheel_speeds(v, angles) * base.wheel_radii, flipped * along, atol=1e-8)


@pytest.mark.parametrize("name", ["swerve", "synchro", "tricycle", "ackermann"])
def test_at_rest_the_wheels_stay(name):
    base = BASES[name]
    current = 0.3 + 0.1 * np.arange(len(base.steered))
    np.testing.assert_array_equal(base.steering(np.zeros(3), current), current)
    np.testing.assert_array_equal(base.steering(np.zeros(3)), 0.0)
    np.testing.assert_array_equal(base.wheel_speeds(np.zeros(3)), 0.0)


def test_limited_wheels_turn_around_their_rest_whatever_they_stand_at():
    car = BASES["ackermann"]
    v = np.array([0.05, 0.0, -1.2])  # 2.3 m to the side of a front wheel that points the other way
    np.testing.assert_allclose(car.steering(v, [1.5, 1.5]), car.steering(v), atol=1e-12)
    assert np.abs(car.steering(v, [1.5, 1.5])).max() <= np.pi / 2


@given(st.sampled_from(["swerve", "synchro"]), twists, st.integers(-30, 30))
def test_half_turns_of_the_wheels_do_not_matter(name, v, turns):
    base = BASES[name]
    assume(np.linalg.norm(v[:2]) > 0.01)
    straight = base.steering(v)
    np.testing.assert_allclose(
        base.steering(v, straight + turns * np.pi + 0.1), straight + turns * np.pi, rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("name", ["swerve", "tricycle", "synchro"])
def test_the_forward_model_of_wheels_that_steer_and_drive_solves_nothing(name):
    kernel = BASES[name].kernel("twist")
    assert "/" not in "".join(line for line in kernel.source.splitlines() if line.startswith("t"))
    assert [f.name for f in kernel.outputs] == ["twist"]


def test_the_inverse_model_of_wheels_that_steer_alone_takes_no_trigonometry():
    kernel = BASES["swerve"].kernel("free_wheel_speeds")
    assert "sincos" not in kernel.source.replace("import sincos", "")
    assert "arctan2(" not in kernel.source
    assert [f.name for f in kernel.outputs] == ["speeds"]


@pytest.mark.parametrize("name", ["tricycle", "ackermann", "synchro", "swerve", "mecanum"])
def test_compiled_equals_float_form(name):
    base = BASES[name]
    k = len(base.steered)
    rng = np.random.default_rng(8)
    v = base.feasible(rng.uniform(-1, 1, (600, 3)))
    steering = base.steering(v)
    speeds = base.wheel_speeds(v, steering)
    few = slice(0, 40)
    np.testing.assert_allclose(base.steering(v[few]), steering[few], atol=1e-12)
    np.testing.assert_allclose(base.wheel_speeds(v[few], steering[few]), speeds[few], atol=1e-11)
    np.testing.assert_allclose(base.wheel_speeds(v), speeds, atol=1e-9)
    np.testing.assert_allclose(base.twist(speeds, steering), v, atol=1e-9)
    angles = list(steering[0]) if k else [0.0]
    plain, drag = base.equation("wheel_speeds").equation(list(v[0]), angles)
    np.testing.assert_allclose(speeds[0], plain, atol=1e-11)
    assert abs(drag[0]) < 1e-12
    plain, *_ = base.equation("twist").equation(list(speeds[0]), angles)
    np.testing.assert_allclose(plain, v[0], atol=1e-11)


@pytest.mark.parametrize("name", ["mecanum", "swerve", "ackermann"])
def test_verbs_broadcast_take_lists_and_write_into_out(name):
    base = BASES[name]
    v = [0.4, 0.0, 0.2]
    speeds, angles = base.wheel_speeds(v), base.steering(v)
    k, m = len(base.steered), len(base.driven)
    assert speeds.shape == (m,)
    assert angles.shape == (k,)
    grid = np.tile(v, (2, 300, 1))
    for rows in (grid, grid[:, :5]):
        out, back = np.empty((*rows.shape[:2], m)), np.empty((*rows.shape[:2], 3))
        assert base.wheel_speeds(rows, out=out, threads=2) is out
        np.testing.assert_allclose(out, np.broadcast_to(speeds, out.shape), atol=1e-12)
        assert base.twist(out, angles if k else None, out=back, threads=2) is back
        np.testing.assert_allclose(back, rows, atol=1e-12)
        assert base.residual(out, angles if k else None).shape == out.shape
    many = np.tile(angles, (7, 1))
    assert base.rolling_matrix(many).shape == (7, 4, 3)
    assert base.sliding(v, many).shape == (7, len(base.sliding_names))
    assert base.wheel_speeds(v, many).shape == ((7, m) if k else (m,))
    assert base.wheel_speeds(np.empty((0, 3))).shape == (0, m)
    with pytest.raises(ShapeError, match="out="):
        base.wheel_speeds(grid, out=np.empty((3, m)))


def test_a_dragged_wheel_is_named():
    base = BASES["differential"]
    batch = np.array([[1.0, 0.0, 0.3], [1.0, 0.1, 0.0]])
    with pytest.raises(OutOfLimits, match=r"in row \(1,\) would drag wheel 'left' sideways at 0.1 m/s.*feasible"):
        base.wheel_speeds(batch)
    np.testing.assert_allclose(base.wheel_speeds(batch, tolerance=np.inf)[1], 20.0)
    with pytest.raises(OutOfLimits, match=r"would drag wheel 'rear left' sideways at 0.2"):
        BASES["ackermann"].wheel_speeds([1.0, 0.2, 0.0])
    with pytest.raises(OutOfLimits, match="sideways"):
        BASES["swerve"].wheel_speeds([1.0, 0.2, 0.0], [0.0, 0.0, 0.0, 0.0])
    with pytest.raises(OutOfLimits, match="sideways"):
        BASES["synchro"].wheel_speeds([1.0, 0.2, 0.4])


def test_coupled_steering_takes_the_angle_that_drags_least():
    base = BASES["synchro"]
    v = np.array([0.6, 0.2, 0.5])
    best = float(base.steering(v)[0])
    cost = [np.sum(base.sliding(v, [a]) ** 2) for a in best + np.linspace(-1.5, 1.5, 301)]
    assert int(np.argmin(cost)) == 150
    np.testing.assert_allclose(base.feasible(v), [0.6, 0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(np.cos(base.steering([-1.0, 0.0, 0.0])), -1.0)
    np.testing.assert_allclose(base.steering([-1.0, 0.0, 0.0], [0.2]), 0.0, atol=1e-15)


def test_limited_steering_turns_by_half_and_is_refused_beyond():
    base = WheelBase(
        [
            Wheel.at("steered", 1.0, 0.0, radius=0.1, driven=True, max_steering=0.6, name="front"),
            Wheel.at("fixed", 0.0, 0.3, radius=0.1, name="left"),
            Wheel.at("fixed", 0.0, -0.3, radius=0.1, name="right"),
        ]
    )
    np.testing.assert_allclose(base.steering([-1.0, 0.0, -0.3]), [np.arctan(0.3)])
    np.testing.assert_allclose(base.wheel_speeds([-1.0, 0.0, -0.3]), -10.0 * np.hypot(1.0, 0.3))
    for ask in (base.steering, base.wheel_speeds):
        with pytest.raises(OutOfLimits, match=r"'front' would have to steer 0\.7854 rad; its max_steering is 0\.6"):
            ask([[1.0, 0.0, 0.0], [1.0, 0.0, 1.0]])


def test_speeds_that_do_not_determine_a_twist_are_refused():
    lone = WheelBase([Wheel.at("steered", 0.2, 0.1, radius=0.1, driven=True)])
    with pytest.raises(InputError, match="do not determine the twist"):
        lone.twist([1.0], [0.0])
    two = WheelBase([Wheel.at("swedish", 0.0, y, radius=0.1, driven=True) for y in (0.2, -0.2)])
    with pytest.raises(InputError, match="drive or constrain it with another wheel"):
        two.twist([1.0, 1.0])
    bicycle = WheelBase(
        [Wheel.at("fixed", 0, 0, radius=0.3, driven=True), Wheel.at("steered", 1.0, 0, radius=0.3, name="front")]
    )
    np.testing.assert_allclose(bicycle.twist([2.0], [0.3]), [0.6, 0.0, 0.6 * np.tan(0.3)], atol=1e-12)
    with pytest.raises(InputError, match="at this steering"):
        bicycle.twist([2.0], [np.pi / 2])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda b: b.wheel_speeds([1.0, 0.0]), r"twist has shape \(2,\); \(..., 3\) is needed"),
        (lambda b: b.wheel_speeds(1.0), "twist has shape"),
        (lambda b: b.wheel_speeds([1.0, np.nan, 0.0]), r"twist\[1\] is nan"),
        (lambda b: b.wheel_speeds([[0, 0, 0], [1.0, np.inf, 0.0]]), r"twist\[1\] is inf in row \(1,\)"),
        (lambda b: b.wheel_speeds(["a", "b", "c"]), "not a number"),
        (lambda b: b.twist([1.0, 2.0, 3.0], None), "speeds has shape"),
        (lambda b: b.twist(np.full((600, 4), np.nan), None), r"speeds\[0\] is nan"),
        (lambda b: b.residual([1.0], None), "speeds has shape"),
        (lambda b: b.rolling_matrix([0.0, 0.0]), "steering has shape"),
        (lambda b: b.feasible([np.nan, 0.0, 0.0]), r"twist\[0\] is nan"),
        (lambda b: b.desaturate([np.nan, 1.0], 1.0), "speeds holds nan"),
        (lambda b: b.desaturate([], 1.0), r"speeds has shape \(0,\)"),
        (lambda b: b.castor_rates([1.0, 0.0, 0.0], [0.1]), "turned has shape"),
    ],
)
@pytest.mark.parametrize("name", ["mecanum", "swerve"])
def test_wrong_arrays_are_named(name, call, words):
    with pytest.raises(ShapeError, match=words):
        call(BASES[name])


def test_leading_axes_that_do_not_go_together():
    with pytest.raises(ShapeError, match="do not go together: twist"):
        BASES["swerve"].wheel_speeds(np.zeros((2, 3)), np.zeros((3, 4)))


@pytest.mark.parametrize(
    ("wheels", "options", "words"),
    [
        ([], {}, "no wheels"),
        (["free"], {}, "no driven wheel"),
        (["a", "a"], {}, "several wheels called 'a'"),
        (["a"], {"radius": 0.0}, "radius 0.0"),
        (["a"], {"alpha": -1.0}, "alpha -1.0"),
        (["a"], {"mass": math.nan}, "mass nan"),
        (["a"], {"com_height": -0.1}, "com_height -0.1"),
        (["a"], {"steering_groups": {"g": ["a"]}}, "not steered"),
    ],
)
def test_what_is_no_base_is_refused(wheels, options, words):
    made = [Wheel.at("swedish", 0.1 * k, 0, radius=0.1, driven=n != "free", name=n) for k, n in enumerate(wheels)]
    with pytest.raises(ModelError, match="base") as problem:
        WheelBase(made, **options)
    assert words in str(problem.value)


def test_numbers_that_are_none_are_refused():
    base = BASES["differential"]
    for tolerance in (-1.0, np.nan, "1", True):
        with pytest.raises(OutOfLimits, match=r"tolerance is .*not below zero"):
            base.wheel_speeds([1.0, 0.0, 0.0], tolerance=tolerance)
    for top in ("1", True, np.nan):
        with pytest.raises(OutOfLimits, match="max_speed is"):
            base.desaturate([1.0, 2.0], top)
    for call in (base.wheel_speeds, BASES["swerve"].wheel_speeds):
        with pytest.raises(InputError, match="threads"):
            call(np.zeros((600, 3)), threads=0)
        with pytest.raises(InputError, match="threads"):
            call(np.zeros(3), threads=0)
    with pytest.raises(InputError, match="threads"):
        base.twist(np.zeros((600, 2)), threads=0)
    with pytest.raises(ModelError, match=r"base 'base' has 'left' among its wheels; make each by Wheel"):
        WheelBase(["left"])


def test_unknown_names_and_constant_couplings():
    wheel = Wheel.at("steered", 0.1, 0.0, radius=0.1, driven=True, name="front")
    with pytest.raises(UnknownName, match="front"):
        WheelBase([wheel], steering_groups={"g": ["frnt"]})
    with pytest.raises(ModelError, match="another group"):
        WheelBase([wheel], steering_groups={"g": ["front"], "h": ["front"]})
    rear = [Wheel.at("steered", -0.1, y, radius=0.1, name=f"rear {y}") for y in (0.1, -0.1)]
    with pytest.raises(ModelError, match="name of a wheel that steers alone"):
        WheelBase([wheel, *rear], steering_groups={"front": [w.name for w in rear]})
    with pytest.raises(UnknownName, match="wheel_speeds"):
        BASES["omni3"].equation("wheelspeeds")
    with pytest.raises(InputError, match="its coupling is no constant"):
        _ = BASES["swerve"].velocity_coupling
    assert repr(BASES["omni3"]) == "WheelBase('omni', 3 wheels, 3 driven)"


@settings(max_examples=20)
@given(st.lists(st.floats(-9, 9), min_size=1, max_size=6), st.floats(0.1, 5))
def test_desaturated_speeds_keep_their_ratio(speeds, limit):
    scaled = WheelBase.desaturate(speeds, limit)
    assert np.abs(scaled).max() <= limit * (1 + 1e-12)
    np.testing.assert_allclose(scaled * np.abs(speeds).max(), np.array(speeds) * np.abs(scaled).max(), atol=1e-9)
    with pytest.raises(OutOfLimits, match="max_speed"):
        WheelBase.desaturate(speeds, 0.0)


def test_a_loop_of_single_calls_is_compiled_on_the_way_and_gives_the_same():
    base, v = BASES["swerve"], np.array([0.4, -0.2, 0.7])
    fresh = type(base)(base.wheels, name="fresh swerve")
    angles = [fresh.steering(v) for _ in range(40)]
    speeds = [fresh.wheel_speeds(v, angles[0]) for _ in range(40)]
    np.testing.assert_allclose(angles, np.tile(angles[0], (40, 1)), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(speeds, np.tile(speeds[0], (40, 1)), rtol=0.0, atol=1e-12)
