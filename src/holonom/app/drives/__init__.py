"""Motors, axes and load cycles from files: `holonom check`, `holonom select`."""

__all__: list[str] = []
