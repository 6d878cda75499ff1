"""One configuration per call from Python: the public verb, and the documented fast path beside Pinocchio's binding."""

from __future__ import annotations

import numpy as np
from peers import peer, pinocchio_model

from holonom import load_arm
from holonom.app.bench import Figure, Setting, seconds

CALLS = 5000


def measure(setting: Setting) -> list[Figure]:
    arm, pin = load_arm("puma560"), peer("pinocchio")
    q, qd, x = setting.rng.uniform(-1.0, 1.0, (3, 6))
    tau = np.empty(6)
    time = lambda f: 1e9 * seconds(f, setting, calls=CALLS, rounds=7)  # noqa: E731
    verbs = {
        "inverse_dynamics": lambda: arm.inverse_dynamics(q, qd, x),
        "forward_dynamics": lambda: arm.forward_dynamics(q, qd, x),
        "fk": lambda: arm.fk(q),
        "jacobian": lambda: arm.jacobian(q),
        "mass_matrix": lambda: arm.mass_matrix(q),
    }
    figures = [Figure(f"one call, arm.{name}", time(call), "ns", goal=2000.0) for name, call in verbs.items()]
    peers: dict[str, object] = {}
    if pin is not None:
        model = pinocchio_model(pin, arm)
        data = model.createData()
        peers = {
            "inverse_dynamics": lambda: pin.rnea(model, data, q, qd, x),
            "forward_dynamics": lambda: pin.aba(model, data, q, qd, x),
        }
    for name in ("inverse_dynamics", "forward_dynamics"):
        kernel = arm.kernel(name)
        fast = time(lambda kernel=kernel: kernel.single(q, qd, x, tau))
        through = time(lambda kernel=kernel: kernel(q, qd, x, out=tau))
        theirs = time(peers[name]) if name in peers else None
        figures.append(Figure(f"one call, kernel.single, {name}", fast, "ns", "Pinocchio binding", theirs, 1.0))
        figures.append(Figure(f"one call, kernel(out=), {name}", through, "ns", "Pinocchio binding", theirs, 1.0))
    return figures
