"""The plant of a base: energy, momentum, friction limits, symmetry, convergence."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulated_bases import BASES, DRIVE, LOSSLESS, soccer

from holonom.devices.transmission.kernels import stiction_step
from holonom.errors import ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile import Wheel, WheelBase
from holonom.mobile.arrangements import omni
from holonom.mobile.drive.base_drive import BaseDrive
from holonom.model.gravity import GRAVITY
from holonom.numeric.small_kernels import solve_positive3
from holonom.sim.base.contact_kernels import slip_friction
from holonom.sim.base.floor import CARPET, ICE, Floor, Material, RectangularPatch, RoundPatch
from holonom.sim.base.kernels import BLOCKED, DEAD, _friction, break_motor
from holonom.sim.base.plant import BaseFault, BasePlant

SLICK = Floor(Material(0.0, 0.0, 0.1))


def voltages(n: int, m: int, seed: int = 0, size: float = 10.0) -> np.ndarray:
    """Random steps of 50 ms."""
    rng = np.random.default_rng(seed)
    return np.repeat(rng.uniform(-size, size, (n // 50 + 1, m)), 50, axis=0)[:n]


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("drive", [DRIVE, LOSSLESS], ids=["losses", "lossless"])
@pytest.mark.parametrize("floor", [Floor(), Floor(ICE), SLICK], ids=["carpet", "ice", "slick"])
def test_energy_balance(name: str, drive: BaseDrive, floor: Floor) -> None:
    """Air-gap work is kinetic energy and what friction took, to rounding; no loss is negative."""
    plant = BasePlant(BASES[name], drive, floor)
    log = plant.drive_open(voltages(400, len(plant.base.driven)))
    _, _, airgap, drag, ground = (plant.state[0][n] for n in ("supplied", "heat", "airgap", "drag", "ground"))
    assert airgap == pytest.approx(plant.kinetic_energy() + drag + ground, abs=1e-9 * max(1.0, abs(airgap)))
    assert plant.kinetic_energy() > 0.1
    assert (np.diff(log.energy[:, 4]) >= -1e-12).all()
    assert (np.diff(log.energy[:, 3]) >= -1e-9).all()
    if drive is LOSSLESS:
        castors = any(wheel.kind == "castor" for wheel in plant.base.wheels)  # whose bearings take a little
        assert abs(drag) < (1e-4 if castors else 1e-9) * airgap + 1e-9


@pytest.mark.parametrize("name", BASES)
def test_electrical_energy(name: str) -> None:
    """What the supply gives is heat, air-gap work and the field in the coils, in the limit of small steps."""
    errors = []
    for substeps in (4, 16):
        plant = BasePlant(BASES[name], DRIVE, substeps=substeps)
        plant.drive_open(voltages(300, len(plant.base.driven)))
        s = plant.state[0]
        field = 0.5 * DRIVE.motor.inductance * (plant.states["current"] ** 2).sum()
        errors.append(abs(s["supplied"] - s["heat"] - s["airgap"] - field) / s["supplied"])
    assert errors[1] < 0.01
    assert errors[1] < 0.35 * errors[0]


@pytest.mark.parametrize("name", BASES)
@settings(max_examples=10)
@given(seed=st.integers(0, 10**6), peak=st.floats(0.05, 1.2))
def test_no_force_beyond_friction(name: str, seed: int, peak: float) -> None:
    plant = BasePlant(BASES[name], DRIVE, Floor(Material(peak, 0.7 * peak, 0.05)), substeps=2)
    log = plant.drive_open(voltages(200, len(plant.base.driven), seed, 14.0))
    force = np.hypot(log.forces, log.cross_forces)
    assert (force <= log.friction_limits * (1.0 + 1e-12) + 1e-12).all()
    assert force.max() > 0.01
    assert (log.loads >= 0.0).all()


def test_loads_carry_the_weight_and_shift_with_acceleration() -> None:
    plant = BasePlant(soccer(com_height=0.1), DRIVE)
    log = plant.drive_open(np.tile(8.0 * np.sign(plant.rows[:, 0]), (100, 1)))
    k = slice(5, 60)
    np.testing.assert_allclose(log.loads[k].sum(axis=1), 6.35 * GRAVITY, rtol=1e-12)
    x = np.array([w.x for w in plant.base.wheels if w.driven])
    moment = log.loads[k] @ x
    forward = log.acceleration[k, 0]
    assert np.abs(forward).max() > 1.0
    np.testing.assert_allclose(moment[1:], -6.35 * 0.1 * forward[1:], atol=0.05 * np.abs(moment).max())


def test_a_wheel_on_a_slick_floor_spins_alone() -> None:
    """The base stays where it is; the wheel reaches the motor's no-load speed."""
    plant = BasePlant(BASES["omni 4"], LOSSLESS, SLICK)
    plant.drive_open(np.tile([6.0, 0.0, 0.0, 0.0], (1500, 1)))
    motor = LOSSLESS.motor
    expected = 6.0 * motor.speed_gain / 3.0
    np.testing.assert_allclose(plant.states["speed"][0], [expected, 0.0, 0.0, 0.0], atol=1e-3 * expected)
    s = plant.state[0]
    assert s["x"] == s["y"] == s["theta"] == 0.0


@given(vx=st.floats(-2, 2), vy=st.floats(-2, 2), w=st.floats(-20, 20))
@settings(max_examples=10)
def test_momentum_without_wheel_force(vx: float, vy: float, w: float) -> None:
    """A base that slides over a slick floor goes straight on and keeps turning."""
    plant = BasePlant(BASES["omni 4"], LOSSLESS, SLICK)
    plant.place((0.1, 0.2, 0.3), (vx, vy, w))
    plant.drive_open(np.zeros((1000, 4)))
    s = plant.state[0]
    c, sn = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose([s["x"], s["y"]], [0.1 + c * vx - sn * vy, 0.2 + sn * vx + c * vy], atol=1e-7)
    assert s["theta"] == pytest.approx(0.3 + w, abs=1e-10)
    c, sn = np.cos(0.3 + w), np.sin(0.3 + w)
    world = np.array([c * s["vx"] - sn * s["vy"], sn * s["vx"] + c * s["vy"]])
    c, sn = np.cos(0.3), np.sin(0.3)
    np.testing.assert_allclose(world, [c * vx - sn * vy, sn * vx + c * vy], atol=1e-7)


@pytest.mark.parametrize("name", BASES)
def test_symmetric_drive_goes_straight(name: str) -> None:
    plant = BasePlant(BASES[name], DRIVE)
    forward = plant.rows @ [1.0, 0.0, 0.0]
    plant.drive_open(np.tile(4.0 * np.sign(forward.round(9)), (800, 1)))
    s = plant.state[0]
    assert s["x"] > 0.3
    assert abs(s["y"]) < 1e-9
    assert abs(s["theta"]) < 1e-9


@pytest.mark.parametrize("name", BASES)
@pytest.mark.parametrize("twist", [(0.5, 0.6, 0.0), (0.0, 0.0, 4.0)])
def test_steady_state_is_the_coupling(name: str, twist: tuple[float, float, float]) -> None:
    """Where nothing slips, wheels turn as the inverse model says: D times the twist, over the wheel radius."""
    plant = BasePlant(BASES[name], LOSSLESS)
    twist = np.array(twist) * [1.0, name != "differential", 1.0]
    wheels = plant.rows @ twist / plant.radii
    u = 3.0 * wheels * LOSSLESS.motor.back_emf_constant
    plant.drive_open(np.tile(u, (4000, 1)))
    s = plant.state[0]
    reached = np.array([s["vx"], s["vy"], s["w"]])
    speeds = plant.states["speed"].flat[: len(plant.base.driven)]
    np.testing.assert_allclose(plant.radii * speeds, plant.rows @ reached, atol=1e-4)
    np.testing.assert_allclose(reached, twist, rtol=3e-3, atol=1e-3)


def test_halving_the_step_converges() -> None:
    """First order: the change halves."""
    ends = []
    for substeps in (2, 4, 8, 16, 64):
        plant = BasePlant(BASES["omni 4"], DRIVE, substeps=substeps)
        plant.drive_open(voltages(600, 4, 3, 6.0))
        ends.append([plant.state[0][n] for n in ("x", "y", "theta")])
    error = np.linalg.norm(np.array(ends[:-1]) - ends[-1], axis=1)
    assert error[0] < 5e-3
    assert (error[1:] < 0.7 * error[:-1]).all(), error


def test_the_same_inputs_give_the_same_bits() -> None:
    logs = [BasePlant(BASES["mecanum"], DRIVE).drive_open(voltages(100, 4)) for _ in range(2)]
    assert logs[0].pose.tobytes() == logs[1].pose.tobytes()
    assert logs[0].forces.tobytes() == logs[1].forces.tobytes()


def test_time_in_one_piece_or_in_two() -> None:
    u = voltages(100, 4)
    one, two = BasePlant(BASES["omni 4"], DRIVE), BasePlant(BASES["omni 4"], DRIVE)
    one.drive_open(u)
    two.drive_open(u[:40])
    two.drive_open(u[40:])
    assert one.state.tobytes() == two.state.tobytes()
    assert one.time == two.time == pytest.approx(0.1)


def test_a_heading_does_not_matter() -> None:
    """The same motion from another pose, turned."""
    a, b = BasePlant(BASES["omni 4"], DRIVE), BasePlant(BASES["omni 4"], DRIVE)
    b.place((0.0, 0.0, 0.7))
    u = voltages(300, 4)
    a.drive_open(u)
    b.drive_open(u)
    c, s = np.cos(0.7), np.sin(0.7)
    x, y = a.state[0]["x"], a.state[0]["y"]
    np.testing.assert_allclose([b.state[0]["x"], b.state[0]["y"]], [c * x - s * y, s * x + c * y], atol=1e-10)


def test_dead_and_blocked_motors() -> None:
    plant = BasePlant(BASES["omni 4"], DRIVE)
    break_motor(plant.states[0], 0, DEAD)
    break_motor(plant.states[0], 1, BLOCKED)
    log = plant.drive_open(np.tile([6.0, 6.0, 6.0, 6.0], (500, 1)))
    assert (log.currents[:, 0] == 0.0).all()
    assert abs(plant.states["speed"][0, 0]) > 5.0  # dragged along
    assert abs(plant.states["speed"][0, 1]) < 1e-6


def test_the_wheel_on_ice_is_the_one_that_spins() -> None:
    base = BASES["omni 4"]
    wheel = base.wheels[2]
    plant = BasePlant(base, DRIVE, Floor(CARPET, (RoundPatch((wheel.x, wheel.y), 0.02),)))
    log = plant.drive_open(np.tile([-6.0, 6.0, 6.0, -6.0], (60, 1)))
    assert np.abs(log.slip[-1]).argmax() == 2
    np.testing.assert_allclose(log.friction_limits[5] / log.loads[5], [0.8, 0.8, 0.06, 0.8], rtol=1e-6)


@pytest.mark.parametrize(("x", "y", "inside"), [(1.0, 2.0, True), (1.35, 2.35, True), (1.35, 1.65, False)])
def test_a_turned_rectangle(x: float, y: float, inside: bool) -> None:
    patch = RectangularPatch((1.0, 2.0), 1.2, 0.2, ICE, np.pi / 4)
    base = BASES["omni 4"]
    plant = BasePlant(base, DRIVE, Floor(CARPET, (patch,)))
    plant.place((x - base.wheels[0].x, y - base.wheels[0].y, 0.0))
    log = plant.drive_open(np.zeros((2, 4)))
    assert (log.friction_limits[1, 0] < 0.1 * log.loads[1, 0]) == inside


@given(peak=st.floats(0.05, 1.5), part=st.floats(0.0, 0.95), at=st.floats(0.01, 0.5))
def test_slip_curve(peak: float, part: float, at: float) -> None:
    """Peak where it is said to be, sliding value far behind it, odd; the kernel and its slope are the same curve."""
    material = Material(peak, part * peak, at)
    assert material.friction(at) == pytest.approx(peak, rel=1e-9)
    assert material.friction(1e6 * at) == pytest.approx(part * peak, abs=1e-4 * peak)
    assert material.friction(-at) == -material.friction(at)
    record = BasePlant(BASES["omni 4"], DRIVE, Floor(material)).params.floor[0]
    for s in at * np.array([-0.9, -0.3, 0.0, 0.2, 0.7]):
        mu, slope = slip_friction(record, s)
        assert mu == pytest.approx(material.friction(s), rel=1e-12)
        d = 1e-6 * at
        assert slope == pytest.approx((material.friction(s + d) - material.friction(s - d)) / (2 * d), rel=1e-4)
    assert slip_friction(record, 2.0 * at)[1] == 0.0


@given(speed=st.floats(-500, 500), part=st.floats(-1.0, 1.0))
def test_motor_friction_is_the_devices(speed: float, part: float) -> None:
    params = DRIVE.friction.stiction(DRIVE.motor.rotor_inertia, 1e-3)
    held = part * params.coulomb_positive
    own = np.array([(held,)], dtype=[("held", float)])[0]
    torque, slope = _friction(params, own, speed)
    expected, held_after = stiction_step(params, held, speed)
    assert (torque, own["held"]) == pytest.approx((expected, held_after), rel=1e-12, abs=1e-18)
    held_by_stop = -params.coulomb_negative < torque - params.viscous * speed < params.coulomb_positive
    assert slope == pytest.approx(params.viscous + (params.winding if held_by_stop else 0.0), rel=1e-9)


@given(seed=st.integers(0, 10**6))
def test_solver(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((3, 3))
    A = A @ A.T + 0.1 * np.eye(3)
    b = rng.standard_normal(3)
    found = solve_positive3(A[0, 0], A[1, 1], A[2, 2], A[0, 1], A[0, 2], A[1, 2], *b)
    np.testing.assert_allclose(found, np.linalg.solve(A, b), rtol=1e-8, atol=1e-10)


def test_bad_input() -> None:
    with pytest.raises(ModelError, match="no mass"):
        BasePlant(omni(n=3, radius=0.1, wheel_radius=0.03), DRIVE)
    with pytest.raises(ModelError, match=r"ball 1.*spherical; simulated are"):
        BasePlant(WheelBase([Wheel.at("spherical", 0.0, 0.0, radius=0.1, driven=True, name="ball 1")], mass=1.0), DRIVE)
    with pytest.raises(UnknownName, match="steered wheel"):
        BasePlant(BASES["omni 4"], DRIVE, faults=[BaseFault(1.0, "wheel 1", "stuck")])
    with pytest.raises(OutOfLimits, match="slope"):
        Floor(slope=2.0)
    with pytest.raises(ShapeError, match="one column per motor"):
        BasePlant(BASES["omni 4"], DRIVE).drive_open(np.zeros((5, 3)))
    with pytest.raises(OutOfLimits, match="substeps"):
        BasePlant(BASES["omni 4"], DRIVE, substeps=0)
    with pytest.raises(OutOfLimits, match="sliding"):
        Material(0.5, 0.6, 0.05)
    with pytest.raises(OutOfLimits, match="width"):
        RectangularPatch((0.0, 0.0), 1.0, 0.0)
    with pytest.raises(UnknownName, match="wheel 1"):
        BasePlant(BASES["omni 4"], DRIVE).wheel_index("wheel 9")
    with pytest.raises(ModelError, match="wheel_inertia"):
        BaseDrive(DRIVE.motor, DRIVE.gear, DRIVE.encoder, wheel_inertia=0.0)
