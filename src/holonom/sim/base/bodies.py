"""A base with what it carries, as the plant takes it: body, wheels and supports about its centre of mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import GRAVITY, BaseDrive, base_mass, load_shares, supports
from holonom.sim.base.balancing import axle_of, lean_params
from holonom.sim.base.floor import Floor
from holonom.sim.base.kernels import Supports
from holonom.sim.base.lean_kernels import LeanParams
from holonom.sim.base.records import BODY, WHEEL
from holonom.sim.base.wheel_rows import Lane, wheel_row
from holonom.trace.call.records import aligned_records, side_by_side

__all__ = ["Bodies", "bodies_of"]

NOTHING = ("share", "share_x", "share_y", "turns", "servo", "lever", "pivot_drag", "reach", "coupled", "radius")
"""What is 0 of the lanes that only fill up a four."""
TICK = 1e-3
Records = NDArray[np.void]


class Bodies(NamedTuple):
    """The moving parts of a base; they change with what it carries."""

    centre: Array  # (2,) in base_link: the centre of mass; of a body that balances the place on its axle beside it
    body: Records
    wheels: Records
    supports: Supports
    lean: LeanParams | None


def bodies_of(base: WheelBase, drive: BaseDrive, floor: Floor, lanes: Sequence[Lane], substeps: int) -> Bodies:
    """Return the moving parts of a base on a floor.

    Raises
    ------
    ModelError
        It states no mass, or balances on anything but one axle.
    """
    centre = axle_of(base) if base.balances else base.com
    shares, contacts = load_shares(base), supports(base) + base.com - centre
    if base.balances:
        shares = np.linalg.pinv(np.vstack([np.ones(len(contacts)), contacts.T]))
    reach, radii = max(float(np.hypot(*contacts.T).max()), 1e-3), base.wheel_radii
    rows = [
        wheel_row(lane, contacts[lane.support], shares[lane.support], drive, TICK / substeps, reach, radii)
        for lane in lanes
    ]
    bearing = 1 + max(lane.support for lane in lanes)
    return Bodies(
        centre,
        _body(base, centre, floor, substeps),
        side_by_side(np.array(rows, WHEEL), **dict.fromkeys(NOTHING, 0.0)),
        Supports(shares[bearing:], np.ascontiguousarray(contacts), np.zeros(len(contacts)), contacts.mean(axis=0)),
        lean_params(base, drive, GRAVITY * math.cos(floor.slope)) if base.balances else None,
    )


def _body(base: WheelBase, centre: Array, floor: Floor, substeps: int) -> Records:
    """The body as a record, on a floor that may be a slope."""
    mass, down = base_mass(base), -GRAVITY * math.sin(floor.slope)
    inertia = base.alpha * mass * base.radius**2
    along = (down * math.cos(floor.uphill), down * math.sin(floor.uphill))
    row = (mass, inertia, base.com_height, TICK / substeps, substeps, *centre.tolist(), *along)
    return aligned_records([(*row, GRAVITY * math.cos(floor.slope))], BODY)
