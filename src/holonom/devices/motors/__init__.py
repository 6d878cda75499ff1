"""Motors: data sheets and the equations of their windings (specification 03.1)."""

__all__: list[str] = []
