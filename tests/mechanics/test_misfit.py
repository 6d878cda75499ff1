"""What an identification doubts: a misfit far above the noise is said, an honest record is not doubted."""

import functools

import numpy as np
import pytest
from identified_arms import planar, torques, with_drives
from scipy.signal import butter, sosfiltfilt

from holonom.mechanics import Arm, load_arm
from holonom.mechanics.identification import excitation, identify, parameters
from holonom.mechanics.identification.columns import regressor_of_rows


def joints_swapped(x):
    return x[:, [1, 0, *range(2, x.shape[1])]]


def turned(joint):
    return lambda x: x * np.where(np.arange(x.shape[1]) == joint, -1.0, 1.0)


def same(x):
    return x


WRONG = {
    "sign of a position": (turned(0), same),
    "sign of another": (turned(2), same),
    "sign of a torque": (same, turned(1)),
    "all torques": (same, np.negative),  # the base parameters fit, but no body has them
    "degrees": (np.degrees, same),
    "positions swapped": (joints_swapped, same),
    "positions and torques swapped": (joints_swapped, joints_swapped),
}


@functools.cache
def recorded(noise=0.01):
    """A record of the three-joint arm: noise is a part of the torques."""
    arm = load_arm("three_joint")
    motion = excitation(arm, duration=8.0, trials=4, dt=0.004, seed=1).trajectory
    tau = torques(arm.model, motion.q, motion.qd, motion.qdd)
    noisy = tau + noise * np.sqrt(np.mean(tau**2, 0)) * np.random.default_rng(3).standard_normal(tau.shape)
    return arm, np.arange(len(tau)) * motion.dt, motion.q, noisy


@pytest.mark.parametrize("wrong", WRONG)
def test_a_misfit_far_above_the_noise_is_said(wrong):
    arm, t, q, tau = recorded()
    of_q, of_tau = WRONG[wrong]
    found = identify(arm, t, of_q(q), of_tau(tau))
    assert "torques are missed far beyond their noise" in found.doubts[0]
    assert (found.misfit > 20.0 * found.explained).any()
    assert any("degrees instead of radians?" in doubt for doubt in found.doubts) == (wrong == "degrees")


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.3])
def test_an_honest_record_is_not_doubted(noise):
    arm, t, q, tau = recorded(noise)
    found = identify(arm, t, q, tau)
    assert found.doubts == ()
    if noise > 0.1:  # white noise is known from what lies above the cutoff
        np.testing.assert_allclose(found.noise, found.explained, rtol=0.15)


def test_noise_that_was_filtered_before_is_no_misfit():
    """Nothing is left above the cutoff to tell it by; but it does not follow the motion."""
    arm, t, q, tau = recorded(0.5)
    sections = butter(4, 2.0 * 15.0 * 0.004, output="sos")
    assert identify(arm, t, q, sosfiltfilt(sections, tau, axis=0)).doubts == ()


def test_fifty_honest_records_are_not_doubted():
    """Random arms with friction and motors, motions, noise of torques from none to a third, of positions to 1e-5."""
    rng, t = np.random.default_rng(0), 0.01 * np.arange(600)
    for k in range(5):
        n = 1 + (k == 0)
        model = with_drives(planar((0.0, -9.81, 0.0), n), k)
        arm, rows = Arm(model), regressor_of_rows(model)
        for _ in range(10):
            spans = ((0.2, 0.6), (0.6, 5.0), (0.0, 6.0))  # rad, rad/s, rad
            a, w, p = (rng.uniform(*span, (n, 4, 1)) for span in spans)
            q, qd = (a * np.sin(w * t + p)).sum(1).T, (a * w * np.cos(w * t + p)).sum(1).T
            tau = rows(q, qd, (-a * w * w * np.sin(w * t + p)).sum(1).T) @ parameters(model)
            noise = rng.uniform(0.0, 0.3) * np.sqrt(np.mean(tau**2, 0)) * rng.standard_normal(tau.shape)
            measured = q + rng.uniform(0.0, 1e-5) * rng.standard_normal(q.shape)
            assert identify(arm, t, measured, tau + noise, cutoff=8.0).doubts == ()
