"""Power stage, supply, brake (specification 03.1)."""

__all__: list[str] = []
