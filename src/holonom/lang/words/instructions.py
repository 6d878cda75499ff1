"""The instructions of the language as a table; those with a syntax of their own are in `compiler`."""

from __future__ import annotations

from holonom.errors import ProgramFault
from holonom.lang.vm.formats import shown
from holonom.lang.vm.state import Status, Variable, Vm
from holonom.lang.words.builtin import Builtin, new_location, real, text
from holonom.lang.words.functions import signals_are
from holonom.lang.words.motions import MOTIONS
from holonom.spatial import inverse

__all__ = ["INSTRUCTIONS", "ending"]


def _hand(vm: Vm, closed: bool) -> bool:
    vm.machine.set_hand(closed)
    return True


def _hand_and_wait(vm: Vm, closed: bool) -> bool:
    """Wait for the arm, work the hand, wait for the hand."""
    state, machine = vm.state, vm.machine
    if state.phase == 0:
        if not machine.idle():
            return False
        machine.set_hand(closed)
        state.phase = 1
        return False
    return machine.hand_idle()


def _signal(vm: Vm, *numbers: float) -> bool:
    for number in numbers:
        if not number.is_integer() or number == 0.0:
            raise ProgramFault(f"SIGNAL {shown(number)}; signals are whole numbers, n for on and -n for off")
    for number in numbers:
        vm.machine.set_signal(int(abs(number)), number > 0)
    outputs = vm.state.outputs
    for number in numbers:
        (outputs.add if number > 0 else outputs.discard)(int(abs(number)))
    return True


def _reset(vm: Vm) -> bool:
    for number in sorted(vm.state.outputs):
        vm.machine.set_signal(number, False)
    vm.state.outputs.clear()
    return True


def _picture(vm: Vm) -> bool:
    vm.state.parts, vm.state.part = vm.machine.picture(), None
    return True


def _locate(vm: Vm, kind: str, place: Variable) -> bool:
    part = vm.machine.locate(kind)
    vm.state.part = part
    if part is not None:
        place.value = inverse(vm.state.settings.base) @ part.pose
    return True


def ending(vm: Vm, status: Status) -> bool:
    """Let the arm come to rest, then stop the program."""
    if not vm.machine.idle():
        return False
    vm.state.status = status
    return True


_KIND_AND_PLACE = (text("$kind"), new_location())
_NUMBER = (real("signal"),)
_TABLE = (
    ("OPEN", (), lambda vm: _hand(vm, False), "open the hand at once"),
    ("CLOSE", (), lambda vm: _hand(vm, True), "close the hand at once"),
    ("RELAX", (), lambda vm: _hand(vm, False), "let go at once; the same as OPEN for a hand with two states"),
    ("OPENI", (), lambda vm: _hand_and_wait(vm, False), "come to rest, open the hand, wait until it is open"),
    ("CLOSEI", (), lambda vm: _hand_and_wait(vm, True), "come to rest, close the hand, wait until it is closed"),
    ("RESET", (), _reset, "switch off every signal that the program switched on"),
    ("VPICTURE", (), _picture, "take a picture; VPARTS is the number of parts in it"),
    ("VLOCATE", _KIND_AND_PLACE, _locate, 'next part of a kind ("" any) into a location; VFEATURE(1) says whether'),
    ("PAUSE", (), lambda vm: ending(vm, Status.PAUSED), "come to rest and wait to be told to proceed"),
    ("HALT", (), lambda vm: ending(vm, Status.HALTED), "come to rest and end the program"),
    ("STOP", (), lambda vm: ending(vm, Status.HALTED), "come to rest and end the program"),
)
_SEVERAL = (
    ("SIGNAL", _NUMBER, _signal, "switch signals: n on, -n off"),
    ("WAIT.SIGNAL", _NUMBER, lambda vm, *n: signals_are(vm, n), "wait until each signal n is on and each -n off"),
)

INSTRUCTIONS: dict[str, Builtin] = {
    i.name: i
    for i in (
        *MOTIONS,
        *(Builtin(*row) for row in _TABLE),
        *(Builtin(name, numbers, run, text, repeat=True) for name, numbers, run, text in _SEVERAL),
    )
}
"""Instructions by name: what they take, what they do, their line of help."""
