"""Sine and cosine of 1 Vpp encoders: signal with its errors, interpolation, correction (specification 03.3)."""

__all__: list[str] = []
