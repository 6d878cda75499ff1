"""The sections of a report, a file each: `SECTION`, whether it applies to a `Source`, and the parts it is made of."""

__all__: list[str] = []
