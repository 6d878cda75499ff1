"""A batch takes the memory of its result and a constant, whatever its size; all verbs refuse the same bad arrays."""

import copy
import gc
import pickle
import tracemalloc

import numpy as np
import pytest

from holonom.errors import InputError, NotAPose, ShapeError
from holonom.mechanics import analysis, dynamics, jacobians, load_arm
from holonom.mechanics.identification import regressor
from holonom.mechanics.numerical_inverse import solve_inverse
from holonom.mechanics.paths import follow
from holonom.mechanics.simulate import simulate, simulate_ensemble
from holonom.mechanics.velocity import follow_path, joint_rates

ARM = load_arm("puma560")
CONSTANT = 1 << 20  # 1 MiB, for chunks and the interpreter
ROWS = 40_000
VERBS = {
    "fk": lambda q, T, **k: ARM.fk(q, **k),
    "jacobian": lambda q, T, **k: ARM.jacobian(q, **k),
    "inverse_dynamics": lambda q, T, **k: ARM.inverse_dynamics(q, q, q, **k),
    "forward_dynamics": lambda q, T, **k: ARM.forward_dynamics(q, q, q, **k),
    "mass_matrix": lambda q, T, **k: ARM.mass_matrix(q, **k),
    "coriolis_matrix": lambda q, T, **k: ARM.coriolis_matrix(q, q, **k),
    "gravity": lambda q, T, **k: ARM.gravity(q, **k),
    "ik": lambda q, T, **k: ARM.ik(T, **k),
    "inverse_dynamics_derivatives": lambda q, T, **k: dynamics.inverse_dynamics_derivatives(ARM, q, q, q, **k),
    "energy": lambda q, T, **k: dynamics.energy(ARM, q, q, **k),
    "regressor": lambda q, T, **k: regressor(ARM, q, q, q, **k),
    "jacobian_rate": lambda q, T, **k: jacobians.jacobian_rate(ARM, q, q, **k),
    "solve_inverse": lambda q, T, **k: solve_inverse(ARM, T[:20], q[:20], limits=False, **k),
}
WITHOUT_THREADS = {
    "ik_nearest": lambda q, T: ARM.ik_nearest(T, q),
    "frames": lambda q, T: ARM.frames(q),
    "joint_torques": lambda q, T: analysis.joint_torques(ARM, q, q),
}


def bytes_of(result):
    return sum(a.nbytes for a in (result if isinstance(result, tuple) else (result,)) if isinstance(a, np.ndarray))


@pytest.mark.parametrize("name", [*sorted(set(VERBS) - {"solve_inverse", "regressor"}), *WITHOUT_THREADS])
def test_memory_of_a_batch_is_its_result_and_a_constant(name):
    verb = (VERBS | WITHOUT_THREADS)[name]
    q = np.random.default_rng(0).uniform(ARM.limits.lower, ARM.limits.upper, (ROWS, ARM.n))
    T = ARM.fk(q)
    T[::7, :3, 3] *= 3.0  # some are out of reach
    verb(q, T)  # compiled
    gc.collect()
    tracemalloc.start()
    try:
        size = bytes_of(verb(q, T))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert size >= 8 * ROWS
    assert peak < 1.01 * size + CONSTANT


@pytest.mark.parametrize("threads", [0, -2, 1.0, 2.5, "2", None])
@pytest.mark.parametrize("name", VERBS)
def test_threads_are_a_whole_number_of_at_least_1(name, threads):
    q = np.full((3, 6), 0.3)
    T = ARM.fk(q)
    for rows in (slice(None), 0):
        if rows == 0 and (name == "solve_inverse" or threads == 1.0):  # one sample: 1.0 is 1
            continue
        with pytest.raises(InputError, match=r"threads is .*; a whole number of at least 1 is needed"):
            VERBS[name](q[rows], T[rows], threads=threads)


def test_an_ensemble_counts_its_threads_too():
    with pytest.raises(InputError, match="threads is 0"):
        simulate_ensemble(ARM, None, np.zeros((2, 6)), np.zeros(6), 0.01, threads=0)


COMPLEX = {
    "fk": lambda z: ARM.fk(z),
    "rows": lambda z: ARM.fk(z[None]),
    "a list": lambda z: ARM.jacobian(z.tolist()),
    "inverse_dynamics": lambda z: ARM.inverse_dynamics(z.real, z, z.real),
    "derivatives": lambda z: dynamics.forward_dynamics_derivatives(ARM, z, z, z),
    "ik_nearest": lambda z: ARM.ik_nearest(ARM.fk(z.real), z),
    "solve_inverse": lambda z: solve_inverse(ARM, ARM.fk(z.real), z),
    "singular values": lambda z: analysis.singular_values(ARM, z),
    "ellipsoid": lambda z: analysis.velocity_ellipsoid(ARM, z),
    "singularities": lambda z: analysis.singularities(ARM, z),
    "largest force": lambda z: analysis.largest_force(ARM, z.real, z[:3]),
    "wrench": lambda z: analysis.joint_torques(ARM, z.real, z),
    "joint rates": lambda z: joint_rates(ARM, z.real, z),
    "follow": lambda z: follow(ARM, ARM.fk(z.real)[None], z),
    "follow_path": lambda z: follow_path(ARM, z, ARM.fk(z.real)[None], 0.01),
    "simulate": lambda z: simulate(ARM, None, z, z.real, 0.01),
}


@pytest.mark.parametrize("verb", COMPLEX.values(), ids=COMPLEX.keys())
def test_complex_numbers_are_refused_and_not_cut_to_their_real_part(verb):
    with pytest.raises(ShapeError, match=r"complex numbers; give real ones"):
        verb(np.full(6, 0.3 + 0.0j))


def test_a_complex_pose_is_none():
    T = ARM.fk(np.full(6, 0.3)) + 0j
    for verb in (ARM.ik, lambda T: ARM.ik_nearest(T, np.zeros(6)), lambda T: solve_inverse(ARM, T)):
        with pytest.raises(NotAPose, match="complex"):
            verb(T)


def test_an_arm_is_copied_and_sent_as_its_model():
    q = np.full(6, 0.3)
    ARM.ik_nearest(ARM.fk(q), q)
    for arm in (copy.deepcopy(ARM), pickle.loads(pickle.dumps(ARM))):
        assert arm.model == ARM.model
        np.testing.assert_array_equal(arm.fk(q), ARM.fk(q))
