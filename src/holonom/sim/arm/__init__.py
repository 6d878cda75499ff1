"""The simulated cell of an arm: plant with drives and servo loops, work pieces, the machines a program can drive."""

__all__: list[str] = []
