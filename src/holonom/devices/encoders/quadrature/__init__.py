"""Two channels and an index, edge by edge: signals with their faults, decoder, receivers (specification 03.3)."""

__all__: list[str] = []
