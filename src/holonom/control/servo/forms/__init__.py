"""The servos, one a file: settings, `design`, the line of the table `SERVOS`."""

__all__: list[str] = []
