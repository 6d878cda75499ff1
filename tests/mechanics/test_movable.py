"""Arms some of whose joints move no mass: named before anything divides by it, in every verb that would."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from holonom.errors import MissingInertia
from holonom.mechanics import Arm
from holonom.mechanics.simulate import simulate
from holonom.mechanics.symbolic import formulas
from holonom.model import ArmModel, Body, Joint, Motor, arm_model_from_dh
from holonom.model.dh import DHRow
from holonom.sim.arm.plant_equation import plant_kernel

BODY = Body(2.0, (-0.3, 0.0, 0.0), (0.01, 0.1, 0.1, 0.0, 0.0, 0.0))
NONE = Body(0.0, (0.0, 0.0, 0.0), (0.0,) * 6)
POINT = Body(1.0, (0.0, 0.0, 0.2), (0.0,) * 6)  # on the axis of its joint
AT, RATE, TORQUE = [0.1, 0.2], [0.3, 0.4], [0.5, 0.6]


def chain(*bodies: Body, reach: float = 0.5) -> ArmModel:
    """A planar arm, its links as long as each other; the frame of a link is at its end."""
    rows = [DHRow(a=reach) for _ in bodies]
    return arm_model_from_dh(rows, convention="standard", name="chain", bodies=bodies)


def moved(body: Body) -> Body:
    """On the joint's axis instead of at the end of the link."""
    return replace(body, com=(-0.5, 0.0, 0.2))


VERBS: dict[str, Callable[[ArmModel], object]] = {
    "forward dynamics": lambda model: Arm(model).forward_dynamics(AT, RATE, TORQUE),
    "rows": lambda model: Arm(model).forward_dynamics(*np.zeros((3, 4, 2))),
    "placed": lambda model: Arm(model).with_gravity([0.0, 0.0, 0.0]).forward_dynamics(AT, RATE, TORQUE),
    "kernel": lambda model: Arm(model).kernel("forward_dynamics"),
    "derivatives": lambda model: Arm(model).kernel("forward_dynamics_derivatives"),
    "floating": lambda model: Arm(replace(model, base_body=BODY)).kernel("floating_forward"),
    "simulation": lambda model: simulate(Arm(model), None, AT, RATE, duration=0.01),
    "formulas": lambda model: formulas(model, "forward_dynamics"),
    "plant": plant_kernel,
}


@pytest.mark.parametrize("verb", VERBS)
def test_the_joint_without_mass_is_named(verb: str) -> None:
    for last in (NONE, moved(POINT)):
        with pytest.raises(MissingInertia, match=r"arm 'chain': joint '\w*2' moves no mass, so its acc"):
            VERBS[verb](chain(BODY, last))


def test_a_subtree_without_mass_is_named_joint_by_joint() -> None:
    with pytest.raises(MissingInertia, match=r"joint '\w*2' and joint '\w*3' move no mass of their own"):
        Arm(chain(BODY, NONE, NONE)).kernel("forward_dynamics")


def test_two_joints_that_move_the_same_alike_are_named() -> None:
    """Both turn about one axis, with nothing between them."""
    with pytest.raises(MissingInertia, match=r"joint '\w*1' and joint '\w*2' move no mass of their own"):
        Arm(chain(NONE, BODY, reach=0.0)).kernel("forward_dynamics")


def test_what_moves_mass_by_carrying_or_by_its_rotor_or_its_load_is_none_of_these() -> None:
    carried = Arm(chain(NONE, BODY))
    qdd = carried.forward_dynamics(AT, RATE, TORQUE)
    np.testing.assert_allclose(carried.inverse_dynamics(AT, RATE, qdd), TORQUE, atol=1e-9)
    model = chain(BODY, NONE)
    driven: tuple[Joint, ...] = tuple(
        replace(j, motor=Motor(gear_ratio=50.0, rotor_inertia=1e-4)) for j in model.joints
    )
    geared = Arm(replace(model, joints=driven))
    np.testing.assert_allclose(geared.mass_matrix(AT)[1], [0.0, 0.25], atol=1e-12)  # 50^2 1e-4
    assert geared.forward_dynamics(AT, [0.0, 0.0], [0.0, 0.5])[1] == pytest.approx(0.5 / 0.25)
    loaded = Arm(model).with_load(BODY)
    qdd = loaded.forward_dynamics(AT, RATE, TORQUE)
    np.testing.assert_allclose(loaded.inverse_dynamics(AT, RATE, qdd), TORQUE, atol=1e-9)


def test_inverse_dynamics_and_the_inertia_need_no_mass() -> None:
    arm = Arm(chain(BODY, NONE))
    assert arm.mass_matrix(AT)[1, 1] == 0.0
    assert arm.inverse_dynamics(AT, RATE, TORQUE)[1] == 0.0
