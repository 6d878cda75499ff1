"""Being moved here from `holonom.sim`."""

__all__: list[str] = []
