"""Two channels and an index, edge by edge: the signal with its faults, the decoder, the receivers (specification 03.3)."""

__all__: list[str] = []
