"""ARPS, the robot language: compiler and virtual machine. The reference is `docs/arps.md`.

Compile
    `load_program` (a file and its location file), `compile_program` (a text), `read_locations`;
    the result is a frozen `Program`; findings that do not stop it are `Diagnostic`.
Run
    `start` makes a `VmState`, `step` runs one tick on a `Machine`, `proceed` ends a PAUSE;
    `Status` says how far it is.
The robot
    `Machine` is the protocol; `Motion`, `Configuration` and `Part` cross it.
Tables of the language
    `INSTRUCTIONS`, `FUNCTIONS`, `FORMATS`, `FEATURES` (what VFEATURE numbers mean), `WORDS`;
    `ARPS_WORDS` lists every word with its help.
"""

from holonom.lang.compiler.compiler import compile_program, load_program
from holonom.lang.compiler.syntax import WORDS
from holonom.lang.diagnostics import Diagnostic
from holonom.lang.locations import read_locations
from holonom.lang.machine import Configuration, Machine, Motion, Part
from holonom.lang.program import Program
from holonom.lang.vm.formats import FORMATS
from holonom.lang.vm.state import Status, VmState
from holonom.lang.vm.vm import proceed, start, step
from holonom.lang.words.functions import FEATURES, FUNCTIONS
from holonom.lang.words.instructions import INSTRUCTIONS
from holonom.lang.words.table import ARPS_WORDS

__all__ = [
    "ARPS_WORDS",
    "FEATURES",
    "FORMATS",
    "FUNCTIONS",
    "INSTRUCTIONS",
    "WORDS",
    "Configuration",
    "Diagnostic",
    "Machine",
    "Motion",
    "Part",
    "Program",
    "Status",
    "VmState",
    "compile_program",
    "load_program",
    "proceed",
    "read_locations",
    "start",
    "step",
]
