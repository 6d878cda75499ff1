from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from arms import random_model, random_tree
from scipy.special import ellipj, ellipk

from holonom.errors import InputError, MissingInertia, OutOfLimits, RunError, ShapeError, UnknownName
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.equations.dynamics.closed_loop import closed_loop
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.inertia import fixed_to_body, from_body
from holonom.mechanics.equations.dynamics.newton_euler import inverse_dynamics
from holonom.mechanics.motion import plan_joint
from holonom.mechanics.simulate import METHODS, ComputedTorque, PDGravity, simulate, simulate_ensemble
from holonom.model import ArmModel, Body, Friction, Joint

Q0 = np.array([0.1, 0.7, -2.8, 0.2, 0.5, 0.1])
STILL = np.zeros(6)
LAW = ComputedTorque(400.0, 40.0, Q0 + 0.3)


@pytest.fixture(scope="module")
def puma() -> Arm:
    return load_arm("puma560")


@pytest.fixture(scope="module")
def small() -> Arm:
    return Arm(random_model(3, 3))


def energy(arm: Arm, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """T + U of every sample, from the mass matrix and the places of the centres of mass."""
    kinetic = 0.5 * np.einsum("ti,tij,tj->t", qd, arm.mass_matrix(q), qd)
    T, g = arm.frames(q)[:, 1:-1], np.array(arm.model.gravity)
    assert arm.model.bodies is not None
    mass = np.array([body.mass for body in arm.model.bodies])
    com = np.array([body.com for body in arm.model.bodies])
    place = (T[..., :3, :3] @ com[..., None])[..., 0] + T[..., :3, 3]
    return kinetic - np.einsum("k,tkx,x->t", mass, place, g)


@pytest.mark.parametrize(("method", "drift"), [("rk4", 1e-8), ("semi_implicit", 2e-2), ("dop853", 1e-8)])
@pytest.mark.parametrize("name", ["puma", "small"])
def test_a_free_arm_without_friction_keeps_its_energy(
    name: str, method: str, drift: float, request: pytest.FixtureRequest
) -> None:
    arm = request.getfixturevalue(name)
    motion = simulate(
        arm, None, np.full(arm.n, 0.3), np.full(arm.n, 0.1), 1.0, dt=5e-4, every=10, method=method, friction=False
    )
    E = energy(arm, motion.q, motion.qd)
    exchanged = np.ptp(0.5 * np.einsum("ti,tij,tj->t", motion.qd, arm.mass_matrix(motion.q), motion.qd))
    assert exchanged > 1.0
    assert np.abs(E - E[0]).max() < drift * exchanged
    assert not motion.tau.any()


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi_implicit", 1)])
def test_order_of_convergence(small: Arm, method: str, order: int) -> None:
    start = np.array([0.3, -0.2, 0.1]), np.array([0.5, 0.2, -0.3])
    exact = simulate(small, None, *start, 0.5, dt=0.05, method="dop853", tolerance=1e-13)
    coarse, fine = (
        np.abs(simulate(small, None, *start, 0.5, dt=dt, every=round(0.05 / dt), method=method).q - exact.q).max()
        for dt in (0.01, 0.005)
    )
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.25)


def test_a_pendulum_swings_as_the_elliptic_sine() -> None:
    """sin(th / 2) = k sn(K(k) - w t, k), k = sin(th0 / 2): Landau and Lifshitz, Mechanics, 11."""
    level = ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    model = ArmModel("swing", (Joint("pivot", "revolute", before=level),), (Body(1.5, (0.0, -0.4, 0.0), (0.0,) * 6),))
    motion = simulate(Arm(model), None, [2.0], [0.0], 3.0, dt=1e-3)
    k, w = np.sin(1.0), np.sqrt(9.81 / 0.4)
    sn = ellipj(ellipk(k * k) - w * motion.t, k * k)[0]
    np.testing.assert_allclose(motion.q[:, 0], 2.0 * np.arcsin(k * sn), atol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_the_closed_loop_is_the_law_before_the_varied_arm(seed: int) -> None:
    """Float form against forward and inverse dynamics of an arm whose bodies are changed by hand."""
    rng = np.random.default_rng(seed)
    model = random_tree(seed, 5)
    n, nominal = len(model.independent), [from_body(body) for body in model.bodies or ()]
    q, qd, reference = rng.uniform(-1, 1, n), rng.uniform(-1, 1, n), rng.uniform(-1, 1, 3 * n)
    masses = rng.uniform(0.5, 2, len(model.joints))
    part = {"gains": rng.uniform(1, 9, 2 * n), "masses": masses, "wrench": rng.uniform(-3, 3, 6),
            "payload": np.array([1.2, 0.1, -0.2, 0.3])}  # fmt: skip
    options = {"law": "computed_torque", "friction": False, "wrench_frame": "tool"}
    qdd, tau = closed_loop(model, nominal, options, (q, qd), reference, part, np.sign(qd))

    kp, kd = part["gains"][:n], part["gains"][n:]
    u = reference[2 * n :] + kd * (reference[n : 2 * n] - qd) + kp * (reference[:n] - q)
    np.testing.assert_allclose(tau, inverse_dynamics(model, nominal, q, qd, u), rtol=1e-12)
    bodies = [
        Body(k * b.mass, b.com, tuple(k * x for x in b.inertia))
        for k, b in zip(part["masses"], model.bodies or (), strict=True)
    ]
    tool = np.array(model.tool)
    load = Body(1.2, tuple(tool[:3, :3] @ part["payload"][1:] + tool[:3, 3]), (0.0,) * 6)
    bodies[model.tool_joint] = fixed_to_body(bodies[model.tool_joint], load)
    plant = [from_body(body) for body in bodies]
    wanted = forward_dynamics(model, plant, q, qd, tau, wrench_tool=part["wrench"])
    np.testing.assert_allclose(qdd, wanted, rtol=1e-9)


def test_compiled_equals_float(puma: Arm) -> None:
    rng = np.random.default_rng(0)
    options = {"law": "computed_torque", "varied": ("payload",), "friction": True, "wrench_frame": None}
    q, qd, slip, reference, parameters = (rng.uniform(-1, 1, k) for k in (6, 6, 6, 18, 16))
    part = {"gains": parameters[:12], "payload": parameters[12:]}
    bodies = [from_body(body) for body in puma.model.bodies or ()]
    exact = closed_loop(puma.model, bodies, options, (q, qd), reference, part, slip)
    found = puma.kernel("closed_loop", **options)(q, qd, slip, reference, parameters)
    for a, b in zip(found, exact, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9)


def test_computed_torque_makes_the_error_linear(puma: Arm) -> None:
    """e'' + 40 e' + 400 e = 0 from rest: e = e0 (1 + 20 t) exp(-20 t), whatever the arm does."""
    motion = simulate(puma, LAW, Q0, STILL, 0.4, friction=False)
    e = -0.3 * (1.0 + 20.0 * motion.t) * np.exp(-20.0 * motion.t)
    np.testing.assert_allclose(motion.q - Q0 - 0.3, np.broadcast_to(e[:, None], motion.q.shape), atol=1e-6)


def test_computed_torque_follows_a_trajectory_and_holds_its_end(puma: Arm) -> None:
    there = plan_joint(Q0, Q0 + np.array([0.3, -0.2, 0.4, 0.1, -0.5, 0.2]), puma.limits)
    law, time = ComputedTorque(400.0, 40.0, there), there.duration + 0.1
    for friction, near in ((False, 1e-6), (True, 2e-4)):  # Coulomb friction starts and stops with a step
        motion = simulate(puma, law, Q0, STILL, time, dt=there.dt, friction=friction)
        np.testing.assert_allclose(motion.q[: len(there.q)], there.q, atol=near)
        np.testing.assert_allclose(motion.q[-1], there.q[-1], atol=near)


def test_pd_with_gravity_rests_at_the_reference_only_without_payload(small: Arm) -> None:
    wanted = np.array([0.2, -0.1, 0.3])
    law = PDGravity(900.0, 150.0, wanted)
    free = simulate(small, law, np.zeros(3), np.zeros(3), 20.0)
    np.testing.assert_allclose(free.q[-1], wanted, atol=1e-6)
    laden = simulate(small, law, np.zeros(3), np.zeros(3), 20.0, payload=2.0)
    weight = small.jacobian(laden.q[-1])[:3].T @ (2.0 * np.array(small.model.gravity))
    assert np.abs(weight).max() > 1.0
    np.testing.assert_allclose(900.0 * (laden.q[-1] - wanted), weight, atol=1e-4)


@pytest.mark.parametrize("method", [*METHODS, "dop853"])
def test_a_controller_in_python_equals_the_compiled_law(small: Arm, method: str) -> None:
    wanted = np.array([0.4, 0.1, -0.2])

    def law(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        return 30.0 * (wanted - q) - 9.0 * qd + small.gravity(q)

    start = np.zeros(3), np.zeros(3)
    compiled = simulate(small, PDGravity(30.0, 9.0, wanted), *start, 0.2, method=method)
    python = simulate(small, law, *start, 0.2, method=method)
    for name in ("t", "q", "qd", "tau"):
        np.testing.assert_allclose(getattr(python, name), getattr(compiled, name), atol=1e-8)


def test_a_wrench_that_the_torque_answers_moves_nothing(small: Arm) -> None:
    q, h = np.array([0.4, 0.1, -0.2]), np.array([3.0, -1.0, 2.0, 0.5, 0.2, -0.4])
    tau = small.gravity(q) + small.jacobian(q, frame="world").T @ h
    motion = simulate(small, lambda t, *_: tau, q, np.zeros(3), 0.01, wrench=h, wrench_frame="world")
    np.testing.assert_allclose(motion.q[-1], q, atol=1e-12)
    moved = simulate(small, lambda t, *_: tau, q, np.zeros(3), 0.01)
    assert np.abs(moved.q[-1] - q).max() > 1e-5


def test_variations_equal_one_simulation_each(puma: Arm) -> None:
    count = 70  # a full block of lanes and a part of one
    payload = np.linspace(0.0, 4.0, count)
    many = simulate_ensemble(puma, LAW, Q0, STILL, 0.1, payload=payload, every=10, threads=2)
    assert many.q.shape == many.tau.shape == (count, 11, 6)
    assert not many.diverged.any()
    for k in (0, 33, 63, 64, 69):
        one = simulate(puma, LAW, Q0, STILL, 0.1, payload=payload[k], every=10)
        for name in ("q", "qd", "tau"):
            np.testing.assert_allclose(getattr(many, name)[k], getattr(one, name), rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(many.t, one.t)


def test_masses_friction_and_starts_vary(small: Arm) -> None:
    joints = tuple(
        dataclasses.replace(joint, friction=friction)
        for joint, friction in zip(small.model.joints, _frictions(), strict=True)
    )
    arm = Arm(dataclasses.replace(small.model, joints=joints))
    masses, scale = np.array([[1.0, 1.0, 1.0], [2.0, 1.0, 0.5]]), np.array([[1.0] * 3, [0.0, 2.0, 3.0]])
    starts = np.array([[0.1, 0.2, 0.3], [-0.2, 0.1, 0.0]])
    speed = np.array([0.1, 1.0, -0.2])  # joint 2, which has Coulomb friction, does not stop
    many = simulate_ensemble(arm, None, starts, speed, 0.2, masses=masses, friction_scale=scale)
    assert (many.qd[:, :, 1] > 0.0).all()
    for k in range(2):
        bodies = tuple(
            Body(m * b.mass, b.com, tuple(m * x for x in b.inertia))  # type: ignore[arg-type]
            for m, b in zip(masses[k], small.model.bodies or (), strict=True)
        )
        changed = tuple(
            dataclasses.replace(
                j, friction=type(f)(*(s * np.array([f.viscous, f.coulomb_positive, f.coulomb_negative])))
            )
            for j, f, s in zip(joints, _frictions(), scale[k], strict=True)
        )
        alone = Arm(dataclasses.replace(arm.model, bodies=bodies, joints=changed, name=f"varied{k}"))
        x, v, dt = starts[k], speed, 1e-3
        for row in range(201):
            np.testing.assert_allclose(many.q[k, row], x, atol=1e-9)
            x, v = _rk4(alone, x, v, dt)


def _frictions():
    return [Friction(0.5, 0.0, 0.0), Friction(0.2, 0.01, 0.02), Friction(0.1, 0.0, 0.0)]


def _rk4(arm: Arm, x: np.ndarray, v: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """One step of the textbook's method, over the float form of the equations."""
    bodies = [from_body(body) for body in arm.model.bodies or ()]

    def rate(y: np.ndarray) -> np.ndarray:
        qdd = forward_dynamics(arm.model, bodies, y[:3], y[3:], np.zeros(3), friction=True)
        return np.concatenate([y[3:], qdd])

    y = np.concatenate([x, v])
    a = rate(y)
    b = rate(y + 0.5 * dt * a)
    c = rate(y + 0.5 * dt * b)
    d = rate(y + dt * c)
    y = y + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
    return y[:3], y[3:]


def rough_arm(gravity: tuple[float, float, float] = (0.0, 0.0, 0.0), ratio: float = 1.0) -> Arm:
    """A Puma without gravity whose joints have nothing but Coulomb friction, of another torque each way."""
    model = load_arm("puma560").model
    torque = [6.0, 9.0, 5.0, 1.5, 1.2, 1.0]
    joints = tuple(
        dataclasses.replace(j, friction=Friction(0.0, f, 1.3 * f, ratio, 0.05 if ratio > 1.0 else 0.0))
        for j, f in zip(model.joints, torque, strict=True)
    )
    return Arm(dataclasses.replace(model, joints=joints, gravity=gravity, name="rough"))


METHOD = pytest.mark.parametrize("method", list(METHODS))


@METHOD
@pytest.mark.parametrize("seed", range(4))
def test_what_is_driven_below_its_breakaway_torque_stays_where_it_is(seed: int, method: str) -> None:
    """All joints at once, under gravity, each near its own limit: not an ulp of motion; a little more, and it goes."""
    arm = rough_arm((0.0, 0.0, -9.81))
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.0, 1.0, 6)
    forward = np.array([j.friction.coulomb_positive for j in arm.model.joints])  # type: ignore[union-attr]
    part = rng.choice([-1.3, 1.0], 6)
    hold = arm.gravity(q) + 0.999 * part * forward
    still = simulate(arm, lambda t, *_: hold, q, STILL, 0.1, method=method)
    np.testing.assert_array_equal(still.q, np.broadcast_to(q, still.q.shape))
    assert not still.qd.any()
    k = seed
    more = hold + 0.002 * part * forward * (np.arange(6) == k)
    moving = simulate(arm, lambda t, *_: more, q, STILL, 0.1, method=method)
    assert np.sign(moving.qd[-1, k]) == np.sign(part[k])
    others = np.arange(6) != k
    np.testing.assert_array_equal(moving.q[1, others], q[others])


@METHOD
@pytest.mark.parametrize("ratio", [1.0, 1.5])
def test_coulomb_friction_never_gives_energy_and_brings_all_to_rest(ratio: float, method: str) -> None:
    arm = rough_arm(ratio=ratio)
    speeds = np.random.default_rng(5).uniform(-1.5, 1.5, (8, 6))
    runs = simulate_ensemble(arm, None, Q0, speeds, 2.0, method=method)
    for q, qd in zip(runs.q, runs.qd, strict=True):
        E = 0.5 * np.einsum("ti,tij,tj->t", qd, arm.mass_matrix(q), qd)
        assert np.diff(E).max() <= (1e-9 if method == "rk4" else 2e-3) * E[0]
        assert E[0] > 1.0
        assert E[-1] == 0.0  # not small: zero
        stopped = int(np.argmax(E == 0.0))
        np.testing.assert_array_equal(q[stopped:], np.broadcast_to(q[-1], q[stopped:].shape))


def test_a_joint_stops_where_mechanics_says() -> None:
    """I qdd = -F: the way is I v^2 / (2 F), the time I v / F, whatever the step."""
    arm = rough_arm()
    q, axis = Q0, 5
    inertia = arm.mass_matrix(q)[axis, axis]
    lock = np.where(np.arange(6) == axis, 1.0, 1e6)  # the other joints do not slip
    v = 3.0 * (np.arange(6) == axis)
    for dt in (1e-2, 1.3e-3, 1e-4):
        run = simulate_ensemble(arm, None, q, v, 1.0, dt=dt, friction_scale=lock)
        assert run.q[0, -1, axis] - q[axis] == pytest.approx(inertia * 9.0 / 2.0, rel=1e-3)
        assert run.t[np.argmax(run.qd[0, :, axis] == 0.0)] == pytest.approx(3.0 * inertia, abs=1.01 * dt)
        assert not run.qd[0, :, :axis].any()


def test_a_joint_that_turns_back_does_so_at_first_order() -> None:
    arm = rough_arm((0.0, 0.0, -9.81))
    tau = arm.gravity(Q0) + np.array([0.0, -60.0, 20.0, 0.0, 8.0, 0.0])
    v = np.array([0.3, 0.5, -0.4, 0.2, -0.3, 0.1])
    ends = [simulate(arm, lambda t, *_: tau, Q0, v, 0.2, dt=dt).q[-1] for dt in (8e-4, 4e-4, 2e-4, 2.5e-5)]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert errors[0] < 2e-3
    assert errors[2] < 0.5 * errors[0]


def test_one_arm_and_each_of_an_ensemble_stick_alike() -> None:
    arm = rough_arm((0.0, 0.0, -9.81), ratio=1.4)
    law = PDGravity(40.0, 3.0, Q0 + 0.1)
    payload = np.linspace(0.0, 2.0, 70)
    many = simulate_ensemble(arm, law, Q0, STILL, 1.0, payload=payload, threads=2, every=10)
    for k in (0, 64, 69):
        one = simulate(arm, law, Q0, STILL, 1.0, payload=payload[k], every=10)
        np.testing.assert_allclose(many.q[k], one.q, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(many.qd[k], one.qd, rtol=0.0, atol=1e-8)
        assert not one.qd[-1].any()  # short of the reference, and standing there
    at = [law.kp * (law.reference - q) - law.kd * qd + arm.gravity(q) for q, qd in zip(one.q, one.qd, strict=True)]
    np.testing.assert_allclose(one.tau, at, atol=1e-9)

    def python(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        return law.kp * (law.reference - q) - law.kd * qd + arm.gravity(q)  # type: ignore[operator]

    slow = simulate(arm, python, Q0, STILL, 1.0, payload=2.0, every=10)
    np.testing.assert_allclose(slow.q, one.q, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_mimic_joints_share_what_holds_them(seed: int) -> None:
    """A tree with a joint that follows another one: friction of both holds the one that leads."""
    model = random_tree(seed, 5)
    joints = tuple(dataclasses.replace(j, friction=Friction(0.0, 2.0, 3.0)) for j in model.joints)
    arm = Arm(dataclasses.replace(model, joints=joints, name=f"rough{seed}"))
    led = {j.mimic.joint: j.mimic.multiplier for j in joints if j.mimic is not None}
    assert led
    q = np.full(arm.n, 0.2)
    for way in (1.0, -1.0):
        own = 2.0 if way > 0.0 else 3.0
        extra = [led.get(i, 0.0) * way for i in model.independent]
        room = np.array([own + abs(m) * (2.0 if m > 0.0 else 3.0) for m in extra])
        for share_, stays in ((0.999, True), (1.001, False)):
            tau = arm.gravity(q) + way * share_ * room
            run = simulate(arm, lambda t, *_, tau=tau: tau, q, np.zeros(arm.n), 0.01)
            assert np.array_equal(run.q[-1], q) == stays


def test_one_variation_that_diverges_leaves_the_others_alone(puma: Arm) -> None:
    payload = np.zeros(130)
    payload[5] = -20.0  # no mass: the inertia becomes negative
    many = simulate_ensemble(puma, LAW, Q0, STILL, 1.0, payload=payload, every=100)
    assert np.flatnonzero(many.diverged).tolist() == [5]
    calm = np.delete(many.q, 5, axis=0)
    np.testing.assert_allclose(calm, np.broadcast_to(calm[0], calm.shape), atol=1e-12)
    with pytest.raises(RunError, match=r"no longer finite at t = .* smaller dt"):
        simulate(puma, LAW, Q0, STILL, 1.0, payload=-20.0)
    with pytest.raises(RunError, match="no longer finite"):
        simulate(puma, lambda t, q, qd: 1e4 * qd + 1e3, Q0, STILL, 5.0, dt=1e-2)


def test_bad_input(puma: Arm) -> None:
    with pytest.raises(UnknownName, match=r"no integration method 'euler'; there is dop853, rk4, semi_implicit"):
        simulate(puma, None, Q0, STILL, 1.0, method="euler")
    with pytest.raises(OutOfLimits, match="duration is -1"):
        simulate(puma, None, Q0, STILL, -1.0)
    with pytest.raises(OutOfLimits, match="every is 0"):
        simulate(puma, None, Q0, STILL, 1.0, every=0)
    with pytest.raises(ShapeError, match=r"q0 has shape \(5,\); \(\.\.\., 6\)"):
        simulate(puma, None, Q0[:5], STILL, 1.0)
    spoilt = np.where(np.arange(6) == 4, np.nan, Q0)
    with pytest.raises(ShapeError, match=r"q0\[4\] is nan; finite"):
        simulate(puma, None, spoilt, STILL, 1.0)
    with pytest.raises(ShapeError, match=r"q0\[4\] is nan in row \(1,\); finite"):
        simulate_ensemble(puma, LAW, np.stack([Q0, spoilt]), STILL, 1.0)
    with pytest.raises(ShapeError, match=r"controller's torque at t = 0 s has shape \(5,\)"):
        simulate(puma, lambda t, q, qd: q[:5], Q0, STILL, 1.0)
    with pytest.raises(InputError, match="wrench_frame"):
        simulate(puma, None, Q0, STILL, 1.0, wrench=np.zeros(6))
    with pytest.raises(UnknownName, match="wrench frame 'base'"):
        simulate(puma, None, Q0, STILL, 1.0, wrench=np.zeros(6), wrench_frame="base")
    with pytest.raises(OutOfLimits, match="kp is -1"):
        simulate(puma, PDGravity(-1.0, 1.0), Q0, STILL, 1.0)
    with pytest.raises(ShapeError, match=r"payload: 3, q0: 2|numbers of variations differ"):
        simulate_ensemble(puma, LAW, np.stack([Q0, Q0]), STILL, 1.0, payload=np.zeros(3))
    with pytest.raises(InputError, match="no one reference to hold"):
        simulate_ensemble(puma, PDGravity(1.0, 1.0), np.stack([Q0, Q0]), STILL, 1.0)
    with pytest.raises(InputError, match="compiled code"):
        simulate_ensemble(puma, lambda t, q, qd: q, Q0, STILL, 1.0)  # type: ignore[arg-type]
    bare = Arm(dataclasses.replace(puma.model, bodies=None))
    with pytest.raises(MissingInertia, match="states no masses"):
        simulate(bare, None, Q0, STILL, 1.0)
