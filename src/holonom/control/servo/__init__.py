"""The servo of one axis: loops, their design, limits (specification 04.3)."""

__all__: list[str] = []
