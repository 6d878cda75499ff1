"""What a drive knows of itself, compiled: is the encoder right, does the winding conduct? Numbers in, a code out.

The back-emf is the second witness of the speed: `k_e w = u - R i - L di/dt` over the time since the last look. The
index is the witness of the count, the two channels are each other's.
"""

from __future__ import annotations

from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "BLOCKED",
    "CHANNEL",
    "CHECKSUM",
    "COUNTS",
    "DEAD_ENCODER",
    "EDGES",
    "INDEX",
    "LINE",
    "SWAPPED",
    "UNSURE",
    "WATCH_START",
    "WINDING",
    "DriveSeen",
    "DriveWatchParams",
    "DriveWatchState",
    "unsuspecting",
    "watch_drive",
]

UNSURE, LINE, CHECKSUM, CHANNEL, DEAD_ENCODER, SWAPPED = 10, 11, 12, 13, 14, 15
COUNTS, EDGES, INDEX, WINDING, BLOCKED = 16, 17, 18, 19, 20
"""Causes beside those of `axis_violation`: see `Cause`."""
FILTER = 0.3  # of the difference of both speeds, each look
INDEX_WAITS = 6  # looks until a wrong index is believed
NAMING = 3  # looks until it has a name
PUSHES = 0.27  # part of the greatest current, beyond the usual one, that turns any axis
STALLED = 20.0  # counts that the model has an axis turn without an edge
SHOWN = 0.5  # part of that motion that the back-emf shows where an encoder is dead; a shaft at a reversal stands
JAMMED = 20.0  # times the least speed that the model has a shaft turn with, which stands: something holds it
FOLLOWS = 0.2  # part of the greatest current from which on the resistance is followed
CLEAR = 0.03  # part of the resistance's voltage that the back-emf's error may be
FOLLOWING = 2.5e-5  # part of it, each look: as fast as a winding gets warm
LEAST_RESISTANCE, MOST_RESISTANCE = 0.7, 1.6  # parts of the known one: tolerance, and a hot winding
LEAST_PART = 0.02  # of the greatest current: less is nothing
CARRIES = 0.1  # part of the asked current that a winding must carry
NO_CURRENT = 2e-3  # of the greatest current: an open winding carries less
SATURATED = 0.98  # part of the supply, at which a current need not follow
OTHER = 0.3  # part of the speed that its witnesses differ by where the encoder is another one
CERTAIN = 1.4  # times what two speeds may differ by: once is enough
DEAD = 0.15  # part of the other speed, below which an encoder counts nothing


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
    resistance_error, inductance_error, constant_error
        Parts by which resistance, inductance and back-emf constant may differ from what is known.
    patience
        Looks, more of them for than against, that must agree; one that is certain counts as all.
    edges, window
        Edges of one channel within so many looks, without any of the other one, that no shaft makes.
    max_current
        Of the power stage, A.
    max_voltage
        Of the supply, V.
    bad_frames
        Frames in a row with a wrong checksum that are no accident.
    acceleration_per_ampere, friction_current
        k_t / J, rad/s2 per A, and Coulomb friction over k_t, A, as they are known.
    current_before
        Weight of the current at a sample's begin in the mean over it (`1 - mean_weight`).
    skew
        Time by which counts and currents may be taken apart: a sample of the current loop, in looks.
    """

    dt: float
    resolution: float
    inductance: float
    back_emf: float
    resistance: float
    least_speed: float
    resistance_error: float
    inductance_error: float
    constant_error: float
    patience: int
    edges: int
    window: int
    max_current: float
    max_voltage: float
    bad_frames: int
    acceleration_per_ampere: float
    friction_current: float
    current_before: float
    skew: float


class DriveSeen(NamedTuple):
    """What is measured at a look.

    The count and edges of both channels since power-on; what the index and the receivers say (0: nothing wrong);
    whether this frame's checksum was wrong; means of voltage and current since the last look; the current now; the
    current that is asked for; the one that the load usually takes.
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
    usual_current: float


class DriveWatchState(NamedTuple):
    """What was seen at the last look, and what speaks against the drive.

    Attributes
    ----------
    counts, span
        The last count that is believed, looks since then.
    edges_a, edges_b, current
        At the last look.
    resistance
        Followed, ohm.
    speed, emf
        Both speeds, rad/s.
    off, allowed
        Their filtered difference, and what it may be.
    asked, carried
        Filtered sizes of the current that is asked for and of the one that flows, A.
    alone_a, alone_b, looks
        Edges of one channel since the other one had any; looks since when.
    differs, empty, frames, waits
        Evidence that speeds differ, that a winding is open, that frames or the index are wrong.
    pace, still_speed, still_travel
        Speed at the last edges; how fast and how far its current would have turned a shaft since, by the model.
    doubts, doubted_speed, doubted_emf, flowing
        Looks since it was certain that something is wrong, sums of both speeds over them, whether there was any
        current: they tell what it is.
    cause
        What this look found: a code, 0 for nothing, `UNSURE` while it has no name yet.
    """

    counts: int
    span: int
    edges_a: int
    edges_b: int
    current: float
    resistance: float
    speed: float
    emf: float
    off: float
    allowed: float
    asked: float
    carried: float
    alone_a: int
    alone_b: int
    looks: int
    differs: int
    empty: int
    frames: int
    waits: int
    pace: float
    still_speed: float
    still_travel: float
    doubts: int
    doubted_speed: float
    doubted_emf: float
    flowing: bool
    cause: int


WATCH_START = DriveWatchState(
    0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, False, 0
)
"""Of a drive that was never looked at; its resistance is to be put in."""


@loop(error_model="numpy", forceinline=True)
def watch_drive(params: DriveWatchParams, state: DriveWatchState, seen: DriveSeen) -> DriveWatchState:
    """One look: the state with what it adds, and the cause that it finds."""
    p, s = params, state
    good = seen.bad_frame == 0
    span = s.span + 1
    speed = (seen.counts - s.counts) * p.resolution / (p.dt * span) if good else s.speed
    induced = p.inductance * (seen.current - s.current) / p.dt
    driving = seen.voltage - induced
    emf = (driving - s.resistance * seen.mean_current) / p.back_emf
    size = max(abs(seen.current), abs(s.current))
    apart = p.resistance_error * s.resistance * size + p.inductance_error * abs(induced)
    apart = p.least_speed + apart / p.back_emf + p.constant_error * abs(speed) + p.skew * abs(emf - s.emf)
    count = p.resolution / p.dt
    off = s.off + FILTER * (speed - emf - s.off)
    allowed = s.allowed + FILTER * (apart - s.allowed)  # of a filtered difference, its bound through the same filter
    bare = abs(seen.mean_current) < NO_CURRENT * p.max_current  # an open winding: its voltage says nothing
    differs = s.differs
    if good and not bare:
        points = 1 if abs(off) > allowed + FILTER * count or abs(speed - emf) > apart + count else -1
        points = p.patience if abs(speed - emf) > CERTAIN * (apart + count) else points
        differs = min(max(differs + points, 0), p.patience)
    resistance = s.resistance
    if size > FOLLOWS * p.max_current and differs == 0:
        resistance = _followed(p, resistance, driving - p.back_emf * speed, seen.mean_current, speed)
    new_a, new_b = seen.edges_a - s.edges_a, seen.edges_b - s.edges_b
    looks = s.looks + 1
    alone_a = 0 if new_b > 0 or looks > p.window else s.alone_a + new_a
    alone_b = 0 if new_a > 0 or looks > p.window else s.alone_b + new_b
    looks = 0 if (new_a > 0 and new_b > 0) or looks > p.window else looks
    pushes = abs(seen.mean_current - seen.usual_current) - 2.0 * p.friction_current - PUSHES * p.max_current
    moves = new_a + new_b > 0 or not good
    still_speed = 0.0 if moves else s.still_speed + p.dt * p.acceleration_per_ampere * max(pushes, 0.0)
    still_travel = 0.0 if moves else s.still_travel + p.dt * still_speed
    pace = s.pace + FILTER * (abs(speed) - s.pace) if moves else s.pace
    still = still_travel > STALLED * p.resolution and pace > p.least_speed
    stalled = still and (abs(emf) > SHOWN * still_speed or still_speed > JAMMED * p.least_speed)
    asked = s.asked + FILTER * (abs(seen.asked_current) - s.asked)
    carried = s.carried + FILTER * (size - s.carried)
    empty = _emptier(p, s.empty, bare, asked, carried, (driving - p.back_emf * speed) / resistance, speed, seen.voltage)
    frames = 0 if good else s.frames + 1
    waits = s.waits + 1 if seen.index_fault != 0 else 0
    doubts, doubted_speed, doubted_emf, cause, flowing = s.doubts, s.doubted_speed, s.doubted_emf, 0, s.flowing
    if seen.line_fault != 0:
        cause = LINE
    elif frames >= p.bad_frames:
        cause = CHECKSUM
    elif alone_a >= p.edges or alone_b >= p.edges:
        cause = CHANNEL
    elif empty >= 2 * p.patience:
        cause = WINDING
    elif doubts > 0:
        doubts, doubted_speed, doubted_emf, cause = doubts + 1, doubted_speed + speed, doubted_emf + emf, UNSURE
        flowing = flowing or not bare
        if doubts > NAMING:
            cause = _named(alone_a, alone_b, doubted_speed, doubted_emf) if flowing else WINDING
            if cause == DEAD_ENCODER and abs(doubted_emf) < NAMING * p.least_speed:
                cause = BLOCKED
    elif differs >= p.patience or stalled:
        doubts, doubted_speed, doubted_emf, cause, flowing = 1, 0.0, 0.0, UNSURE, False
    elif waits > INDEX_WAITS:  # what else an index that is wrong may come from has shown itself by then
        cause = EDGES if seen.index_fault == 1 else COUNTS
        if seen.index_fault == 2 and abs(off) <= OTHER * abs(speed):
            cause = INDEX
    return DriveWatchState(
        seen.counts if good else s.counts, 0 if good else span, seen.edges_a, seen.edges_b, seen.current, resistance,
        speed, emf, off, allowed, asked, carried, alone_a, alone_b, looks, differs, empty, frames, waits,
        pace, still_speed, still_travel, doubts, doubted_speed, doubted_emf, flowing, cause,
    )  # fmt: skip


@loop(error_model="numpy", forceinline=True)
def _followed(params: DriveWatchParams, resistance: float, voltage: float, current: float, speed: float) -> float:
    """The resistance, a little nearer to what a voltage and a current say, where the back-emf's error is small."""
    p = params
    if p.constant_error * p.back_emf * abs(speed) > CLEAR * resistance * abs(current) or current == 0.0:
        return resistance
    step = FOLLOWING * p.resistance
    nearer = resistance + min(max(voltage / current - resistance, -step), step)
    return min(max(nearer, LEAST_RESISTANCE * p.resistance), MOST_RESISTANCE * p.resistance)


@loop(error_model="numpy", forceinline=True)
def _emptier(
    params: DriveWatchParams, empty: int, bare: bool, asked: float, carried: float, modelled: float, speed: float,
    voltage: float,
) -> int:  # fmt: skip
    """Evidence that the winding is open: no current where the model has some; far less than is asked for."""
    p = params
    nothing = LEAST_PART * p.max_current
    doubt = nothing + p.back_emf * (p.constant_error * abs(speed) + p.resolution / p.dt) / p.resistance
    if bare and abs(modelled) > doubt:
        return empty + 2
    deaf = asked > nothing and carried < CARRIES * asked and abs(voltage) < SATURATED * p.max_voltage
    return empty + 1 if deaf else 0


@loop(error_model="numpy", forceinline=True)
def _named(alone_a: int, alone_b: int, speed: float, emf: float) -> int:
    """What is wrong with an encoder that does not agree with the back-emf."""
    if abs(speed) < DEAD * abs(emf):
        return CHANNEL if alone_a > 1 or alone_b > 1 else DEAD_ENCODER
    return SWAPPED if speed * emf < 0.0 else COUNTS


@loop(error_model="numpy", forceinline=True)
def unsuspecting(state: DriveWatchState, resistance: float) -> DriveWatchState:
    """The state without any evidence, with a resistance (ohm) that was measured."""
    s = state
    return DriveWatchState(
        s.counts, s.span, s.edges_a, s.edges_b, s.current, resistance, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
        0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, False, 0,
    )  # fmt: skip
