"""Bases from URDF and xacro files, and back: `load_base`, `base_urdf`."""

from holonom.mobile.urdf.reader import load_base
from holonom.mobile.urdf.writer import base_urdf

__all__ = ["base_urdf", "load_base"]
