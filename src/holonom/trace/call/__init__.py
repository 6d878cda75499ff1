"""How compiled code is called: arrays in and out, batches, threads."""

__all__: list[str] = []
