"""A straight line as text: for the processor, for a GPU; and the modules made of it."""

__all__: list[str] = []
