"""Ways from counts and the time of their edges to a speed, each with its resolution and delay (specification 03.3)."""

__all__: list[str] = []
