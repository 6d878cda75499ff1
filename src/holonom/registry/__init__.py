"""Tables of methods: what there is of a kind, with its parameters, one line of help, a source, and how it is made.

A method is a `Method` in a file of its own: a params record (a frozen dataclass whose fields are made by `parameter`),
`make`, help, source. One explicit line in its kind's `Table` adds it; a package may add some more by entry points of
the group `holonom.<kind>` whose objects are `Method`s. Nothing is imported before it is used, no folder is scanned.

======================  ========================================================================
`parameter`             a field of a params record: meaning, unit, range, choices
`parameters_of`         the fields of a record, as `Field`s
`check_fields`          for `__post_init__`: every field of a record within its range
`read_record`           names and values to a record; every fault is worded
`Method`, `Table`       one method; all of a kind
======================  ========================================================================
"""

from holonom.registry.methods import OWN, Method, NoParams, Table
from holonom.registry.parameters import (
    Field,
    Parameter,
    check_fields,
    check_value,
    imported,
    parameter,
    parameters_of,
    read_record,
)

__all__ = [
    "OWN",
    "Field",
    "Method",
    "NoParams",
    "Parameter",
    "Table",
    "check_fields",
    "check_value",
    "imported",
    "parameter",
    "parameters_of",
    "read_record",
]
