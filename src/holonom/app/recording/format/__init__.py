"""How a recording lies in a file: MCAP, ROS 2 messages, their codecs."""

__all__: list[str] = []
