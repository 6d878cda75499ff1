"""Logs of odometry: wheels and ground truth of one base, from the files in which they come.

Reading
    `read_log`: a folder of the OptiOdom data set (or one above several), one of its files, or the TOML file of the
    plain format (`plain`, which describes it) whose runs are CSV or MCAP files; an `OdometryLog`.
Writing
    `write_log`: the plain format, with CSV or MCAP runs.
Inside
    `table` (numbers out of CSV, faults with line and column), `checks` (time, speeds, units, swapped columns),
    `optiodom`, `plain`, `rates` (two rates, stamps), `mcap_file`, `recorded` (files of ROS 2, poses in them).
"""

from holonom.app.odometry_log.log import OdometryLog
from holonom.app.odometry_log.reader import read_log
from holonom.app.odometry_log.writer import write_log

__all__ = ["OdometryLog", "read_log", "write_log"]
