"""What a drive knows of itself, compiled: is the encoder right, does the winding conduct? Numbers in, a code out.

The back-emf is the second witness of the speed: `k_e w = u - R i - L di/dt` over the time since the last look. The index
is the witness of the count, the two channels are each other's.
"""

from __future__ import annotations

from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "CHANNEL",
    "CHECKSUM",
    "COUNTS",
    "DEAD_ENCODER",
    "EDGES",
    "INDEX",
    "LINE",
    "SWAPPED",
    "WINDING",
    "DriveSeen",
    "DriveWatchParams",
    "DriveWatchState",
    "watch_drive",
]

LINE, CHECKSUM, CHANNEL, DEAD_ENCODER, SWAPPED, COUNTS, EDGES, INDEX, WINDING = 11, 12, 13, 14, 15, 16, 17, 18, 19
"""Causes beside those of `axis_violation`: see `Cause`."""
FILTER = 0.3  # of the difference of both speeds, each look
FOLLOWS = 0.2  # part of the greatest current from which on the resistance is followed
FOLLOWING = 2e-3  # part of it, each look
LEAST_RESISTANCE, MOST_RESISTANCE = 0.7, 1.6  # parts of the known one: tolerance, and a hot winding
LEAST_PART = 0.02  # of the greatest current: less is nothing
CARRIES = 0.1  # part of the current that a winding must carry
SATURATED = 0.98  # part of the supply, at which a current need not follow
DEAD = 0.2  # part of the other speed, below which an encoder counts nothing


class DriveWatchParams(NamedTuple):
    """What `watch_drive` compares by; rad/s and A at the motor.

    Attributes
    ----------
    dt
        Time between two looks, s.
    resolution
        rad per count.
    inductance, back_emf
        Of the winding as its sheet has them, H and V s/rad.
    resistance
        As its sheet, or the self-check, has it, ohm; it is followed from there.
    least_speed
        Difference of speeds that is always allowed.
    resistance_error, constant_error
        Parts by which resistance and back-emf constant may differ from what is known.
    patience
        Looks in a row that must agree.
    edges, window
        Edges of one channel within so many looks, without any of the other one, that no shaft makes.
    max_current
        Of the power stage, A.
    max_voltage
        Of the supply, V.
    bad_frames
        Frames in a row with a wrong checksum that are no accident.
    """

    dt: float
    resolution: float
    inductance: float
    back_emf: float
    resistance: float
    least_speed: float
    resistance_error: float
    constant_error: float
    patience: int
    edges: int
    window: int
    max_current: float
    max_voltage: float
    bad_frames: int


class DriveSeen(NamedTuple):
    """What is measured at a look: the count and edges of both channels since power-on; what the index and the receivers
    say (0: nothing wrong); whether this frame's checksum was wrong; means of voltage and current since the last look; the
    current now; the current that is asked for.
    """

    counts: int
    edges_a: int
    edges_b: int
    index_fault: int
    line_fault: int
    bad_frame: int
    voltage: float
    mean_current: float
    current: float
    asked_current: float


class DriveWatchState(NamedTuple):
    """What was seen at the last look, and what speaks against the drive.

    `resistance` is followed; `speed` and `emf` are both speeds, `off` their filtered difference; `alone_a`, `alone_b`
    edges of one channel since the other one had any, `looks` since when; the rest counts looks in a row. `cause` is the
    first that was found, 0 until then.
    """

    counts: int
    edges_a: int
    edges_b: int
    current: float
    resistance: float
    speed: float
    emf: float
    off: float
    alone_a: int
    alone_b: int
    looks: int
    differs: int
    empty: int
    frames: int
    cause: int


@loop(error_model="numpy", forceinline=True)
def watch_drive(params: DriveWatchParams, state: DriveWatchState, seen: DriveSeen) -> DriveWatchState:
    """One look: the state with what it adds, and the first cause."""
    p, s = params, state
    speed = (seen.counts - s.counts) * p.resolution / p.dt
    driving = seen.voltage - p.inductance * (seen.current - s.current) / p.dt
    emf = (driving - s.resistance * seen.mean_current) / p.back_emf
    off = s.off + FILTER * (speed - emf - s.off)
    size = max(abs(seen.current), abs(s.current))
    allowed = p.least_speed + FILTER * p.resolution / p.dt
    allowed += p.resistance_error * s.resistance * size / p.back_emf + p.constant_error * abs(speed)
    differs = s.differs + 1 if abs(off) > allowed else 0
    resistance = s.resistance
    if size > FOLLOWS * p.max_current and differs == 0:
        found = (driving - p.back_emf * speed) / seen.mean_current
        step = FOLLOWING * p.resistance
        resistance += min(max(found - resistance, -step), step)
        resistance = min(max(resistance, LEAST_RESISTANCE * p.resistance), MOST_RESISTANCE * p.resistance)
    new_a, new_b = seen.edges_a - s.edges_a, seen.edges_b - s.edges_b
    looks = s.looks + 1
    alone_a = 0 if new_b > 0 or looks > p.window else s.alone_a + new_a
    alone_b = 0 if new_a > 0 or looks > p.window else s.alone_b + new_b
    looks = 0 if (new_a > 0 and new_b > 0) or looks > p.window else looks
    modelled = (driving - p.back_emf * speed) / s.resistance
    doubt = LEAST_PART * p.max_current + p.constant_error * p.back_emf * abs(speed) / s.resistance
    carries = abs(seen.mean_current) > CARRIES * max(abs(modelled), abs(seen.asked_current))
    asked = abs(seen.asked_current) > LEAST_PART * p.max_current and abs(seen.voltage) < SATURATED * p.max_voltage
    empty = s.empty + 1 if (abs(modelled) > doubt or asked) and not carries else 0
    frames = s.frames + 1 if seen.bad_frame != 0 else 0
    cause = s.cause
    if cause == 0:
        if seen.line_fault != 0:
            cause = LINE
        elif frames >= p.bad_frames:
            cause = CHECKSUM
        elif alone_a >= p.edges or alone_b >= p.edges:
            cause = CHANNEL
        elif empty >= p.patience:
            cause = WINDING
        elif differs >= p.patience:
            cause = COUNTS
            if abs(speed) < DEAD * abs(emf):
                cause = DEAD_ENCODER
            elif speed * emf < 0.0:
                cause = SWAPPED
        elif seen.index_fault == 1:
            cause = EDGES
        elif seen.index_fault == 2:
            cause = INDEX
        elif seen.index_fault == 3:
            cause = COUNTS
    return DriveWatchState(
        seen.counts, seen.edges_a, seen.edges_b, seen.current, resistance, speed, emf, off, alone_a, alone_b, looks,
        differs, empty, frames, cause,
    )  # fmt: skip
