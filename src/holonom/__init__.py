"""Holonom: a robot control system in Python."""
