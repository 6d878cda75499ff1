"""What a person touches: commands, cell files, recordings, reports.

=====================  ==============================================================
`cli`                  the command line
`cell`                 cell files and their schema
`arm`, `base`          cells of an arm and of a mobile base: tables, assembly, run, check
`run`, `check`         the commands; `calibrate`, `bench` and `doctor` too
`recording`            MCAP files of ROS 2 messages, written and read
`report`               the self-contained HTML report
=====================  ==============================================================
"""

__all__: list[str] = []
