"""Contact force at an arm's tool by its motor currents, with its error (spec 03.5, 000 1.8.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import finite_array
from holonom.devices import ContactForce, contact_force
from holonom.errors import InputError, ModelError
from holonom.machine.arm.servos import joint_motor
from holonom.mechanics import Arm
from holonom.mechanics.motion.trajectory import joint_vector
from holonom.model import Friction
from holonom.registry import check_fields, parameter

__all__ = ["ContactErrors", "contact_by_currents"]


@dataclass(frozen=True, slots=True)
class ContactErrors:
    """How well torques are known.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    current: float = parameter(0.05, meaning="of a measured current", unit="A", least=0.0)
    model: float = parameter(0.05, meaning="part by which the model's torque may be off", least=0.0)
    friction: float = parameter(0.2, meaning="part by which friction at speed may be off", least=0.0)
    rest: float = parameter(0.01, meaning="speed of a joint below which it may stand", unit="rad/s", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


def contact_by_currents(
    arm: Arm,
    q: ArrayLike,
    qd: ArrayLike,
    qdd: ArrayLike,
    currents: ArrayLike,
    *,
    frame: str,
    errors: ContactErrors = ContactErrors(),
) -> ContactForce:
    """Return the wrench that an arm exerts at its tool point, by its motors' currents: `J^-T (tau_motor - tau_model)`.

    Friction is what limits it: a joint that stands may be held by all of its static friction, which no current shows,
    and by what its gear loses. Both are in `error`. An arm of three to five joints tells the force alone, and takes the
    contact to be at the tool point, without a moment.

    Parameters
    ----------
    q, qd, qdd : (n,) rad, rad/s, rad/s2 (joints that slide: m, ...).
    currents : (n,) A, measured; means where the arm hunts by a count of its encoders.
    frame : "world" or "tool", which the wrench is expressed in.
    errors : of current, model and friction.

    Returns
    -------
    Wrench (6,) or force (3,), with its error.

    Raises
    ------
    ModelError
        A joint without motor data.
    InputError
        Another frame.
    OutOfLimits
        A configuration in which some force loads no motor; fewer than three joints.
    ShapeError, NotFinite
    """
    if frame not in ("world", "tool"):
        raise InputError(f'frame is {frame!r}; it must be "world" or "tool"')
    q, qd, qdd = (joint_vector(name, x, arm.n) for name, x in (("q", q), ("qd", qd), ("qdd", qdd)))
    measured = finite_array("currents", currents, (arm.n,))
    motors = [joint_motor(joint) for joint in arm.model.joints]
    data = [joint.motor for joint in arm.model.joints if joint.motor is not None]
    constants = np.array([d.gear_ratio * m.torque_constant for d, m in zip(data, motors, strict=True)])
    smooth = arm.inverse_dynamics(q, qd, qdd, friction=False)
    rubbing = arm.inverse_dynamics(q, qd, qdd) - smooth
    at_rest = np.abs(qd) <= errors.rest
    still = np.maximum([_breakaway(joint.friction) for joint in arm.model.joints], np.abs(rubbing))
    unsure = np.where(at_rest, still, errors.friction * np.abs(rubbing))
    felt, given = np.where(at_rest, still, np.abs(rubbing) + unsure), constants * measured
    lost = np.array([1.0 / d.gear_efficiency - 1.0 for d in data]) * (np.abs(given) + felt)
    doubt = errors.model * np.abs(smooth) + np.abs(constants) * errors.current + unsure + lost
    modelled = smooth + np.where(at_rest, 0.0, rubbing)
    rows = 6 if arm.n >= 6 else 3
    return contact_force(arm.jacobian(q, frame=frame)[:rows], given, modelled, doubt)


def _breakaway(friction: Friction | None) -> float:
    """Torque (N m) that a joint at rest may be held with."""
    if friction is None:
        return 0.0
    return max(friction.coulomb_positive, friction.coulomb_negative) * max(friction.static_ratio, 1.0)
