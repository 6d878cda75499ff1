"""Messages of recordings by ROS 2: what holds them, and the poses in them."""

__all__: list[str] = []
