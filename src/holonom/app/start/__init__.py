"""Where a person begins: the examples that come with Holonom, the first cell of their own, and its check.

=================  ==================================================================
`demo`             where the examples lie, in a clone and in an installed package
`new`              `new_cell`: a folder with a commented cell and a program that fits it
`arm`, `base`      what is written for an arm, for a base; `agv` puts one on the other
`check`            `check_file`: what is wrong with a program or a cell
`text`             values and comments as a cell file has them
=================  ==================================================================
"""

__all__: list[str] = []
