"""Cells of a mobile base: what their file says, the simulation it becomes, running and checking it.

=====================  ==============================================================
`cell_model`           the tables of the cell file
`assembly`             from a cell's data to base, drives, floor and path
`run`, `check`         the commands
`outcome`              faults, found or not, and path errors, from the log of a run
`report`, `scene`      what the report shows
=====================  ==============================================================
"""

__all__: list[str] = []
