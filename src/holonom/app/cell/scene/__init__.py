"""What the report draws of a cell: bodies, floor, views."""

__all__: list[str] = []
