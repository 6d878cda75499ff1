"""Sensors other than encoders: tachometer, current, inertial, force (specification 03.4)."""

__all__: list[str] = []
