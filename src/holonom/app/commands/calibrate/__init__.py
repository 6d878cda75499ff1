"""The subjects of `holonom calibrate`, one file each."""

__all__: list[str] = []
