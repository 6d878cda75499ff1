"""What a report says: verdict, peaks, tracking, comparison, facts of a base."""

__all__: list[str] = []
