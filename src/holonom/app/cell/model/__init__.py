"""The cell as data: what a file may say, and what each value means."""

__all__: list[str] = []
