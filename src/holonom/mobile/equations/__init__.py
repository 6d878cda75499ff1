"""Equations of wheels and bases, plain Python over scalars, traced."""
