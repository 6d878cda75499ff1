"""What a person touches: commands, cell files, recordings, reports.

=====================  ==============================================================
`cli`                  the command line
`cell`, `cell_model`   cell files and their schema
`camera`, `assembly`   from a cell's data to camera, arm, plant, world, scene
`run`, `check`         the commands; `bench` and `doctor` too
`recording`            MCAP files of ROS 2 messages, written and read
`report`               the self-contained HTML report
=====================  ==============================================================
"""

__all__: list[str] = []
