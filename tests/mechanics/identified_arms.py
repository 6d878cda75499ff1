"""Arms that are identified, and what their joints measure."""

import dataclasses

import numpy as np

from holonom.mechanics.equations.dynamics import newton_euler
from holonom.mechanics.kernels.table import bodies_of
from holonom.model import Body, DHRow, Friction, Motor, arm_model_from_dh


def with_drives(model, seed):
    """The model with motors, their axes and friction on all joints."""
    rng = np.random.default_rng(seed)

    def drive(joint):
        axis = rng.standard_normal(3)
        motor = Motor(
            float(rng.uniform(-80, 80)),
            float(rng.uniform(1e-4, 1e-3)),
            axis=tuple((axis / np.linalg.norm(axis)).tolist()),
            mass=0.5,
            transverse_inertia=1e-3,
        )
        return dataclasses.replace(joint, motor=motor, friction=Friction(*rng.uniform(0.1, 3.0, 3).tolist()))

    return dataclasses.replace(model, joints=tuple(drive(joint) for joint in model.joints))


def torques(model, q, qd, qdd, friction=True):
    """Newton-Euler, row by row, on floats."""
    rows = zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True)
    return np.array(
        [newton_euler.inverse_dynamics(model, bodies_of(model), *row, friction=friction) for row in rows], dtype=float
    )


def planar(gravity, n=2):
    rows = [DHRow(a=0.5), DHRow(a=0.4), DHRow(a=0.3)][:n]
    bodies = [Body(2.0, (-0.2, 0.02, 0.0), (0.01, 0.05, 0.05, 0.0, 0.0, 0.0))] * n
    model = arm_model_from_dh(rows, convention="standard", name="planar", bodies=bodies)
    return dataclasses.replace(model, gravity=gravity)
