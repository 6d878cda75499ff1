"""Values of a file: quantities with units, methods by name, and the line of a fault."""

__all__: list[str] = []
