"""A cell file: what it says, and the job that it becomes.

=====================  ==============================================================
`load_cell`, `Cell`    the file, read and checked: one model of lists of tables
`cell_schema`          its JSON Schema
`build.build_job`      the `Job` of a cell: domain objects
`scene.build_scene`    what the replay shows
=====================  ==============================================================
"""

from holonom.app.cell.load import load_cell, place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.schema import cell_schema

__all__ = ["Cell", "cell_schema", "load_cell", "place_in"]
