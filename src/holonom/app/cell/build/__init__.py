"""From a cell to the job that runs: robots, laws, tasks, sensors."""

__all__: list[str] = []
