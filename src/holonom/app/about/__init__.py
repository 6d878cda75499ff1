"""What an installation has and how fast it is: `doctor`, `methods`, `bench`."""

__all__: list[str] = []
