"""The simulated mobile base: motors, wheels that slip on a floor, a rigid body, its controller in one compiled loop."""

__all__: list[str] = []
