"""Loops of a base: estimate, path keeping, traction, force, shaping of velocities; tuning of its wheels."""

__all__: list[str] = []
