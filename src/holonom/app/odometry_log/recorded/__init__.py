"""Recordings, by ROS 2 and by ourselves: what holds them, the poses in them, what their wheels creep."""

__all__: list[str] = []
