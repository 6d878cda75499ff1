"""The command line itself: options, answers, progress, interrupts, exit statuses."""

__all__: list[str] = []
