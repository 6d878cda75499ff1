"""From an equation to a straight line of operations."""

__all__: list[str] = []
