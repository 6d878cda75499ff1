"""The words of ARPS: instructions, functions, built-in variables, one table."""

__all__: list[str] = []
