"""What runs a program: machine state, arithmetic, formats."""

__all__: list[str] = []
