"""What stands between supply and motor: bridge, supply, limiter, brake (specification 03.1)."""

__all__: list[str] = []
