"""Contact force by motor torques: what they give beyond what a model asks for (spec 03.5, 000 1.8.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array
from holonom.errors import OutOfLimits

__all__ = ["ContactForce", "contact_force"]

LEAST_SINGULAR = 1e-6  # smallest over largest singular value


@dataclass(frozen=True, slots=True)
class ContactForce:
    """A wrench [f; m], or as many of its components as the Jacobian has rows.

    Attributes
    ----------
    wrench
        (m,), N and N m, that the arm exerts on its surroundings, in the Jacobian's frame.
    error
        (m,): none is off by more, as long as no torque is off by more than was stated.
    residual
        Largest torque (N m) that no wrench at the Jacobian's point explains; beyond the stated errors there is another
        contact, or the model is wrong. 0 where there are as many joints as components.
    """

    wrench: Array
    error: Array
    residual: float


def contact_force(
    jacobian: ArrayLike, tau_motor: ArrayLike, tau_model: ArrayLike, tau_error: ArrayLike
) -> ContactForce:
    """Return `J^-T (tau_motor - tau_model)`; with more joints than components, by least squares.

    Parameters
    ----------
    jacobian : (m, n), m up to n: linear rows first.
    tau_motor : (n,) N m, by measured currents.
    tau_model : (n,) N m, of the same motion without contact.
    tau_error : (n,) N m, at least 0: by how much their difference may be off.

    Raises
    ------
    OutOfLimits
        A negative error, more components than joints, a singular Jacobian: some force loads no motor.
    ShapeError, NotFinite
    """
    J = finite_array("jacobian", jacobian, ("m", "n"))
    m, n = J.shape
    torques = finite_array("tau_motor", tau_motor, (n,)) - finite_array("tau_model", tau_model, (n,))
    errors = finite_array("tau_error", tau_error, (n,))
    if (errors < 0.0).any():
        raise OutOfLimits(f"tau_error holds {errors.min():g}; magnitudes of at least 0 are needed")
    if m > n or m == 0:
        raise OutOfLimits(f"{n} joints cannot tell {m} components of a wrench; give at most {n} rows of the Jacobian")
    U, s, Vt = np.linalg.svd(J, full_matrices=False)
    if not s[-1] > LEAST_SINGULAR * s[0]:
        raise OutOfLimits(
            f"the Jacobian is singular (singular values {s[0]:.3g} to {s[-1]:.3g}): some force loads no motor; "
            "move the arm, or give fewer rows"
        )
    back = (U / s) @ Vt  # pseudo-inverse of J^T
    wrench = back @ torques
    left = torques - J.T @ wrench if m < n else np.zeros(n)
    return ContactForce(wrench, np.abs(back) @ errors, float(np.abs(left).max()))
