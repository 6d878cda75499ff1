"""The controller of one axis: encoder, observer, three loops."""

__all__: list[str] = []
