"""Pictures of a report: scene, plan view, curves, polar figures."""

__all__: list[str] = []
