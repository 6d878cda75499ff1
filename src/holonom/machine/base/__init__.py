"""The controller of a mobile base: `controller` (the verb), `kernels` (its compiled step), `paths`, `settings`."""

__all__: list[str] = []
