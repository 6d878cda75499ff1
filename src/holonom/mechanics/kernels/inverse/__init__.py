"""Closed-form inverses: which one an arm has, and its kernel."""

__all__: list[str] = []
