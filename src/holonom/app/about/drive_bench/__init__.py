"""`holonom bench drive`: every law of a path on every arrangement; how errors of odometry grow."""

__all__: list[str] = []
