"""From text to a program: syntax, symbols, statements, expressions."""

__all__: list[str] = []
