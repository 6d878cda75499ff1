"""`SteadyTool`: keeps an arm's tool where it is in the world while the base that carries the arm moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from holonom.arrays import Array
from holonom.errors import MotionError
from holonom.mechanics import Arm, IkStatus
from holonom.spatial import inverse

__all__ = ["SteadyTool"]

Frame = Callable[[], Array]


class SteadyTool:
    """References that hold a pose in the world; between two ticks joints move evenly.

    Mutable state: the pose held, the joints asked for last, where the base believed to stand then.

    Parameters
    ----------
    arm
        Its model, on the base's mount.
    frame
        T (4, 4) of its base in the world, as the base that carries it believes to stand.
    tick
        Time between two references, s.
    """

    def __init__(self, arm: Arm, frame: Frame, tick: float) -> None:
        self._arm, self._frame, self._tick = arm, frame, tick
        self._held: Array | None = None
        self._q = self._qd = np.zeros(arm.n)
        self._before = np.eye(4)

    def release(self) -> None:
        """Hold nothing: the arm moves by itself."""
        self._held = None

    def reference(self, q: Array, samples: int) -> Array:
        """Positions, speeds, accelerations (3, samples, n) of the next tick; `q` (n,) is where the arm stands at first.

        Raises
        ------
        MotionError
            The base has carried the pose out of the arm's reach, or further than its joints' speeds allow.
        """
        now = self._frame()
        if self._held is None:
            self._held, self._q, self._qd, self._before = now @ self._arm.fk(q), q, np.zeros(self._arm.n), now
        ahead = now @ inverse(self._before) @ now  # where it will be after the tick, if it goes on as in the last one
        found = self._arm.ik_nearest(inverse(ahead) @ self._held, self._q)
        speed = (found.q - self._q) / self._tick
        if found.status not in (IkStatus.OK, IkStatus.SINGULAR):
            raise MotionError(
                "the tool cannot stay where it is in the world: the base carries it out of the arm's reach"
            )
        fast = np.abs(speed) > self._arm.limits.speed
        if fast.any():
            name = self._arm.limits.names[int(np.argmax(fast))]
            raise MotionError(f"the tool cannot stay where it is in the world: {name} would pass its speed limit")
        share = np.arange(samples)[:, None] / samples
        rates = np.broadcast_to(speed, (samples, self._arm.n))
        ramp = np.broadcast_to((speed - self._qd) / self._tick, rates.shape)
        positions = self._q + share * (found.q - self._q)
        self._q, self._qd, self._before = found.q, speed, now
        return np.stack([positions, rates, ramp])
