"""Rules of tuning, one a file: settings, gains, the line of the table."""

__all__: list[str] = []
