"""What is between a motor and its joint: gears, friction (specification 03.2)."""

__all__: list[str] = []
