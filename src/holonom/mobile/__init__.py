"""Mobile bases: wheels, what drives them, odometry and its calibration (specification 06)."""
