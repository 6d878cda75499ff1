"""The forms of regulators, one a file: settings, compiled `step` and `start`, the line of the table."""

__all__: list[str] = []
