"""Parameters from recordings: of an arm's dynamics, of a base's odometry."""

__all__: list[str] = []
