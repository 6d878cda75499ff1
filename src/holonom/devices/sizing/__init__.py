"""From a load's motion to the motor and gear that make it (specification 03.1, 03.2)."""

__all__: list[str] = []
