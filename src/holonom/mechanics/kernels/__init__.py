"""Equations compiled for one model: builders, and `table`, which names them."""

__all__: list[str] = []
