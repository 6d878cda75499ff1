"""How loops become machine code, and where it is kept."""

__all__: list[str] = []
