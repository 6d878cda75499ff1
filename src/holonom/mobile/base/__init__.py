"""`WheelBase`: wheels on one rigid body, and what follows from where they stand."""

from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["WheelBase"]
