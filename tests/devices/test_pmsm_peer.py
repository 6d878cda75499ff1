"""PMSM beside gym-electric-motor's equations and its integrator."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from holonom.devices import Dq, Pmsm, pmsm_step

MOTOR = Pmsm(18e-3, 0.37e-3, 1.2e-3, 66e-3, 3, 0.03883, 300.0, 400.0)


@pytest.mark.oracle
@pytest.mark.parametrize("speed", [0.0, 150.0, -400.0])
def test_a_step_and_its_torque_are_the_peers(speed: float) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the peer's own imports
        gem = pytest.importorskip(
            "gym_electric_motor",
            reason="gym-electric-motor is not installed; pip install -e '.[oracle]'",
            exc_type=ImportError,
        )
        theirs = gem.make("Cont-TC-PMSM-v0").unwrapped.physical_system.electrical_motor
    parameters = theirs.motor_parameter
    values = (MOTOR.resistance, MOTOR.inductance_d, MOTOR.inductance_q, MOTOR.flux, MOTOR.pole_pairs)
    assert values == tuple(parameters[name] for name in ("r_s", "l_d", "l_q", "psi_p", "p"))
    voltage = np.array([-12.0, 25.0])

    def rates(_: float, x: np.ndarray) -> np.ndarray:
        return np.asarray(theirs.electrical_ode(np.append(x, 0.0), voltage, speed), float)[:2]

    exact = solve_ivp(rates, (0.0, 1e-3), [30.0, -50.0], method="Radau", rtol=1e-9, atol=1e-9).y[:, -1]
    found = pmsm_step(MOTOR.params(), Dq(30.0, -50.0), Dq(*voltage), speed, 1e-3)
    np.testing.assert_allclose(found, exact, rtol=1e-6)
    assert MOTOR.torque(found) == pytest.approx(float(theirs.torque(np.append(exact, 0.0))), rel=1e-6)
