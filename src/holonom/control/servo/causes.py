"""What stops a drive, by name."""

from __future__ import annotations

from enum import IntEnum

from holonom.control.servo.limits import Violation

__all__ = ["Cause"]


class Cause(IntEnum):
    """Causes of a stop: limits, faults that a watch finds, checks that fail before the start."""

    LOST_REFERENCE = Violation.LOST_REFERENCE
    POSITION_LOW = Violation.POSITION_LOW
    POSITION_HIGH = Violation.POSITION_HIGH
    FOLLOWING_ERROR = Violation.FOLLOWING_ERROR
    OVERSPEED = Violation.SPEED
    OVERCURRENT = Violation.CURRENT
    LINE_BROKEN = 11
    CHECKSUM = 12
    CHANNEL_STUCK = 13
    ENCODER_DEAD = 14
    CHANNELS_SWAPPED = 15
    WRONG_COUNTS = 16
    EDGES_LOST = 17
    INDEX_MISSING = 18
    PHASE_LOST = 19
    BLOCKED = 20
    CURRENT_OFFSET = 21
    SUPPLY = 22
    POSITION_UNKNOWN = 23
    BRAKE_SLIPS = 24
    HOMING_TIME_OUT = 25
    HOMING_WRONG_TURN = 26
    HOMING_MISSING_INDEX = 27
    HOMING_MISSING_SWITCH = 28
    HOMING_STUCK_SWITCH = 29
    HOMING_NO_SIGNAL = 30
    HOMING_APART = 31

    @property
    def text(self) -> str:
        """In words."""
        return _WORDS[self]


_WORDS = {
    Cause.LOST_REFERENCE: "the commanded position is no number",
    Cause.POSITION_LOW: "below the position limit",
    Cause.POSITION_HIGH: "above the position limit",
    Cause.FOLLOWING_ERROR: "the following error exceeds its limit",
    Cause.OVERSPEED: "the speed exceeds its limit",
    Cause.OVERCURRENT: "the current exceeds its limit",
    Cause.LINE_BROKEN: "a line of the encoder is broken or swapped, its receiver says",
    Cause.CHECKSUM: "the encoder's frames have wrong checksums",
    Cause.CHANNEL_STUCK: "a channel of the encoder is stuck: the other one has edges alone",
    Cause.ENCODER_DEAD: "the encoder counts nothing while the back-emf shows motion",
    Cause.CHANNELS_SWAPPED: "the encoder counts against the back-emf: its channels are swapped",
    Cause.WRONG_COUNTS: "the encoder has other counts per turn than stated",
    Cause.EDGES_LOST: "edges of the encoder are lost: the index came at another count",
    Cause.INDEX_MISSING: "more than a turn without the index",
    Cause.PHASE_LOST: "the winding carries no current: a phase is open",
    Cause.BLOCKED: "the motor pushes and nothing turns: the axis is blocked",
    Cause.CURRENT_OFFSET: "self-check: the current sensor's zero is off",
    Cause.SUPPLY: "self-check: the supply is outside its range",
    Cause.POSITION_UNKNOWN: "self-check: counter and potentiometer differ",
    Cause.BRAKE_SLIPS: "self-check: the shaft turns against its closed brake",
    Cause.HOMING_TIME_OUT: "homing: the axis does not get to the index in time",
    Cause.HOMING_WRONG_TURN: "homing: index and potentiometer differ, the turn is in doubt",
    Cause.HOMING_MISSING_INDEX: "homing: no index within a turn and a quarter",
    Cause.HOMING_MISSING_SWITCH: "homing: the switch does not close",
    Cause.HOMING_STUCK_SWITCH: "homing: the switch does not open",
    Cause.HOMING_NO_SIGNAL: "homing: the potentiometer shows what it cannot: a broken wire",
    Cause.HOMING_APART: "homing: potentiometer and counter move apart",
}
