"""`holonom tune`: files that describe what is tuned, and the answers."""

__all__: list[str] = []
