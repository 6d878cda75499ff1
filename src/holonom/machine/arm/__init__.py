"""The controller of an arm: motions, their queue, servo loops."""

__all__: list[str] = []
