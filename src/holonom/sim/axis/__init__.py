"""One axis, simulated whole: motor, gear, load and encoder under the loops of its servo."""

__all__: list[str] = []
