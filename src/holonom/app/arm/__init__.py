"""Cells of an arm: what their file says, the simulation it becomes, running and checking it.

=====================  ==============================================================
`cell_model`           the tables of the cell file
`camera`, `assembly`   from a cell's data to camera, arm, plant, world, scene
`job`, `taught`        the program and its locations, looked at before anything moves
`run`, `check`         the commands
`tracking`             how well runs kept to their path
=====================  ==============================================================
"""

__all__: list[str] = []
