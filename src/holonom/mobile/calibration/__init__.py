"""Calibration of odometry: what a base's numbers really are, from runs with ground truth.

======================  ====================================================================
`Run`                   one run: time, wheel turns, steering, truth
`umbmark`               UMBmark: squares both ways round, for differential drives; a `UMBmark`
`calibrate`             least squares from any trajectories; a `Calibration`
`held_out_errors`       what such a calibration is worth on a run it has not seen
`DRIVES`, `SETS`        what can be calibrated: drives with their parameters, sets of these
`drive_parameters`      a set and the motion matrix it makes, as `DriveParameters`
`derived_parameters`    the same of any `WheelBase`, by the kinds of its wheels, as `DerivedParameters`
`identifiability`       which numbers runs tell, and which of `STANDARD_RUNS` would help
`error_growth`          how errors of the wheels grow along a run, by propagation and by simulated runs; `CAUSES`
`end_scatter`           what no calibration takes away: scatter of ends, bumps, as an `EndScatter`
`with_encoders`         a base whose odometry comes from other wheels than those with motors
`article`               a drive with its article, for messages
`wheels_of`             wheels and steered wheels of a drive, in the order of the columns
`dead_reckoning`        poses of a run by odometry; `Motion` is that of a base that steers
`truth_frame`           where the truth's frame is, roughly; `seen_from` is what it sees
`path_errors`           the four error measures, `PathErrors`
`clock_of`              how late the truth's `Clock` is, and at which rate; `clear_clock` where that is clear;
                        `on_the_clock_of_the_wheels` puts it right
======================  ====================================================================
"""

from holonom.mobile.calibration.clocks import Clock, clear_clock, clock_of, on_the_clock_of_the_wheels, truth_frame
from holonom.mobile.calibration.derived import (
    DerivedParameters,
    derived_parameters,
    known_parameters,
    with_encoders,
)
from holonom.mobile.calibration.error_growth import CAUSES, ErrorGrowth, error_growth
from holonom.mobile.calibration.fitting.least_squares import Calibration, calibrate, held_out_errors
from holonom.mobile.calibration.identifiability import Combination, Identifiability, identifiability
from holonom.mobile.calibration.nonsystematic import EndScatter, end_scatter
from holonom.mobile.calibration.parameters import (
    DRIVES,
    SETS,
    DriveParameters,
    Parameters,
    article,
    drive_parameters,
    seen_from,
    wheels_of,
)
from holonom.mobile.calibration.runs import Motion, PathErrors, Run, dead_reckoning, lever_of, path_errors
from holonom.mobile.calibration.standard_runs import STANDARD_RUNS, standard_run
from holonom.mobile.calibration.umbmark import UMBmark, umbmark

__all__ = [
    "CAUSES",
    "DRIVES",
    "SETS",
    "STANDARD_RUNS",
    "Calibration",
    "Clock",
    "Combination",
    "DerivedParameters",
    "DriveParameters",
    "EndScatter",
    "ErrorGrowth",
    "Identifiability",
    "Motion",
    "Parameters",
    "PathErrors",
    "Run",
    "UMBmark",
    "article",
    "calibrate",
    "clear_clock",
    "clock_of",
    "dead_reckoning",
    "derived_parameters",
    "drive_parameters",
    "end_scatter",
    "error_growth",
    "held_out_errors",
    "identifiability",
    "known_parameters",
    "lever_of",
    "on_the_clock_of_the_wheels",
    "path_errors",
    "seen_from",
    "standard_run",
    "truth_frame",
    "umbmark",
    "wheels_of",
    "with_encoders",
]
