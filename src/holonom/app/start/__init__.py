"""What comes first: a new cell or a demo, and a check of what was written."""

=================  ==================================================================
`demo`             where the examples lie, in a clone and in an installed package
`new`              `new_cell`: a folder with a commented cell and a program that fits it
`arm`, `base`      what is written for an arm, for a base; `agv` puts one on the other
`text`             values and comments as a cell file has them
=================  ==================================================================
"""

__all__: list[str] = []
