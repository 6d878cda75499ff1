"""Robot files: URDF and xacro, read strictly."""

__all__: list[str] = []
