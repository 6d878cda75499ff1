"""The virtual machine: one call of `step` is one tick of the program, 10 ms of the robot's time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from holonom.errors import MotionError, ProgramFault, RunawayProgram
from holonom.lang import poses
from holonom.lang.machine import Machine
from holonom.lang.program import Program, Value
from holonom.lang.vm.arithmetic import BINARY, UNARY, finite
from holonom.lang.vm.formats import render, shown
from holonom.lang.vm.state import Frame, Status, Variable, Vm, VmState
from holonom.lang.words.functions import FUNCTIONS, SHIFT, dest, where
from holonom.lang.words.instructions import INSTRUCTIONS, ending
from holonom.lang.words.motions import set_speed, set_tolerance

__all__ = ["proceed", "start", "step"]

_DEEPEST_CALL = 100
_LONGEST_STRING = 1024
_SHOWN_CALLS = 4
"""Of a deep chain of calls a message shows so many from either end."""


def start(program: Program, *, entry: str | None = None, rng: np.random.Generator | None = None) -> VmState:
    """Return the state before the first instruction.

    Parameters
    ----------
    program : Program
        What will run.
    entry : str, optional
        Name of the routine to begin with, one without parameters; the first of the file by default.
    rng : numpy.random.Generator, optional
        What RANDOM draws from; by default one that always gives the same numbers.

    Raises
    ------
    ProgramFault
        When there is no such routine, or it takes parameters.
    """
    names = [routine.name.lower() for routine in program.routines]
    wanted = names[0] if entry is None else entry.lower()
    if wanted not in names:
        raise ProgramFault(f"{program.file}: there is no program {entry!r}; there is {', '.join(names)}")
    index = names.index(wanted)
    routine = program.routines[index]
    if routine.parameters:
        raise ProgramFault(f"{program.file}: {routine.name} takes parameters; begin with one that takes none")
    variables = [Variable(name) for name in routine.variables]
    state = VmState([], [Frame(index, 0, variables, 0)], rng or np.random.default_rng(0))
    for described in program.globals:
        variable = Variable(described.name)
        for indices, pose in described.given:
            (variable.element(indices) if indices else variable).value = pose
        state.globals.append(variable)
    return state


def proceed(state: VmState) -> None:
    """Let a paused program go on with the next tick."""
    if state.status is Status.PAUSED:
        state.status = Status.RUNNING


def step(program: Program, state: VmState, machine: Machine, *, budget: int = 10_000, patience: int = 100) -> Status:
    """Run one tick: operations until one has to wait, the program stops, or the budget is used up.

    Parameters
    ----------
    program : Program
        What runs.
    state : VmState
        Changed in place; `state.copy()` before a call keeps the old one.
    machine : Machine
        The robot.
    budget : int
        Most operations in one tick.
    patience : int
        Ticks in a row that may use up the budget without a motion or a wait.

    Returns
    -------
    Status
        Also in `state.status`; the source line is in `state.line`.

    Raises
    ------
    ProgramFault
        A run-time error or a motion that cannot be made, with file, line and source line. The state is
        halted there.
    RunawayProgram
        After `patience` ticks without a motion or a wait.
    """
    if state.status in (Status.PAUSED, Status.HALTED):
        return state.status
    vm = Vm(program, state, machine)
    state.status = Status.RUNNING
    try:
        waits = _run(vm, budget)
    except (ProgramFault, MotionError) as error:
        state.status = Status.HALTED
        raise ProgramFault(_located(vm, _instruction(vm) + str(error))) from error
    if waits:
        state.status, state.busy_ticks = Status.WAITING, 0
    elif state.status is Status.RUNNING:
        _count_busy(vm, budget, patience)
    return state.status


def _run(vm: Vm, budget: int) -> bool:
    """Run operations; return True when one has to wait for the next tick."""
    state = vm.state
    for _ in range(budget):
        frame = state.frames[-1]
        code, operand, state.line = vm.program.routines[frame.routine].code[frame.pc]
        frame.pc += 1
        if _OPERATIONS[code](vm, operand):
            return True
        if state.status is not Status.RUNNING:
            return False
    return False


def _count_busy(vm: Vm, budget: int, patience: int) -> None:
    vm.state.busy_ticks += 1
    if vm.state.busy_ticks < patience:
        return
    vm.state.status = Status.HALTED
    text = (
        f"a loop that neither moves nor waits: {budget * patience} operations in {patience} ticks; "
        "put a motion, WAIT or DELAY into it"
    )
    raise RunawayProgram(_located(vm, text))


def _instruction(vm: Vm) -> str:
    """Return the name of the instruction or function under way, as the beginning of a message."""
    code, operand, _ = vm.routine.code[vm.frame.pc - 1]
    return f"{operand[0]}: " if code in ("ACTION", "FUNCTION") and isinstance(operand, tuple) else ""


def _located(vm: Vm, text: str) -> str:
    """Return a message with file, line, the source line and the calls that led there."""
    program, line = vm.program, vm.state.line
    calls = [f"\n  called from line {f.called_from}" for f in reversed(vm.state.frames) if f.called_from]
    if len(calls) > 2 * _SHOWN_CALLS:
        left_out = f"\n  ... {len(calls) - 2 * _SHOWN_CALLS} more calls ..."
        calls = [*calls[:_SHOWN_CALLS], left_out, *calls[-_SHOWN_CALLS:]]
    return f"{program.file}:{line}: {text}\n  {line} | {program.source(line)}{''.join(calls)}"


def _again(vm: Vm) -> bool:
    """Stay at this operation and wait for the next tick."""
    vm.frame.pc -= 1
    return True


def _const(vm: Vm, operand: Any) -> None:
    vm.state.stack.append(operand)


def _load_global(vm: Vm, slot: int) -> None:
    vm.state.stack.append(vm.state.globals[slot].read())


def _load_local(vm: Vm, slot: int) -> None:
    vm.state.stack.append(vm.frame.variables[slot].read())


def _ref_global(vm: Vm, slot: int) -> None:
    vm.state.stack.append(vm.state.globals[slot])


def _ref_local(vm: Vm, slot: int) -> None:
    vm.state.stack.append(vm.frame.variables[slot])


def _element(vm: Vm, count: int) -> None:
    indices = _popped(vm, count)
    vm.state.stack.append(vm.state.stack.pop().element(indices))  # type: ignore[union-attr]


def _value(vm: Vm, _: None) -> None:
    stack = vm.state.stack
    stack.append(stack.pop().read())  # type: ignore[union-attr]


def _assign(vm: Vm, _: None) -> None:
    variable, value = _popped(vm, 2)
    variable.value = _kept(value)


def _kept(value: Value) -> Value:
    """Return a value that is going to be stored; strings have a length limit."""
    if isinstance(value, str) and len(value) > _LONGEST_STRING:
        raise ProgramFault(f"a string of {len(value)} characters; the longest is {_LONGEST_STRING}")
    return value


def _popped(vm: Vm, count: int) -> tuple[Any, ...]:
    if not count:
        return ()
    stack = vm.state.stack
    values = tuple(stack[-count:])
    del stack[-count:]
    return values


def _jump(vm: Vm, target: int) -> None:
    vm.frame.pc = target


def _jump_if_false(vm: Vm, target: int) -> None:
    if vm.state.stack.pop() == 0.0:
        vm.frame.pc = target


def _jump_if_true(vm: Vm, target: int) -> None:
    if vm.state.stack.pop() != 0.0:
        vm.frame.pc = target


def _jump_if_past(vm: Vm, target: int) -> None:
    value, limit, stride = _popped(vm, 3)
    if stride == 0.0:
        raise ProgramFault("FOR with a STEP of 0 never ends; give another step")
    if (value > limit) if stride > 0.0 else (value < limit):
        vm.frame.pc = target


def _wait(vm: Vm, start_of_condition: int) -> bool:
    if vm.state.stack.pop() != 0.0:
        return False
    vm.frame.pc = start_of_condition
    return True


def _unary(vm: Vm, name: str) -> None:
    stack = vm.state.stack
    stack.append(UNARY[name](stack.pop()))


def _binary(vm: Vm, name: str) -> None:
    stack = vm.state.stack
    right = stack.pop()
    stack.append(finite(BINARY[name](stack.pop(), right)))


def _compound(vm: Vm, _: None) -> None:
    first, second = _popped(vm, 2)
    vm.state.stack.append(poses.compound(first, second))


def _function(vm: Vm, operand: tuple[str, int]) -> None:
    name, count = operand
    vm.state.stack.append(finite(FUNCTIONS[name].run(vm, *_popped(vm, count))))


def _action(vm: Vm, operand: tuple[str, int]) -> bool:
    """Run an instruction. Its operands stay on the stack until it is done, for the next tick to find."""
    name, count = operand
    state = vm.state
    if not INSTRUCTIONS[name].run(vm, *state.stack[len(state.stack) - count :]):
        return _again(vm)
    _popped(vm, count)
    state.phase = 0
    return False


def _here(vm: Vm, measured: int) -> None:
    vm.state.stack.append(where(vm) if measured else dest(vm))


def _here_joints(vm: Vm, measured: int) -> None:
    vm.state.stack.append((vm.machine.joints() if measured else vm.machine.goal()).copy())


def _shift(vm: Vm, _: None) -> None:
    vm.state.stack.append(SHIFT.run(vm, *_popped(vm, 4)))


def _encode(vm: Vm, codes: tuple[str | None, ...]) -> None:
    vm.state.stack.append(render(_popped(vm, codes.count(None)), codes))


def _type(vm: Vm, codes: tuple[str | None, ...]) -> None:
    state = vm.state
    state.typed += render(_popped(vm, codes.count(None)), codes)
    if codes and codes[-1] == "S" and len(state.typed) < _LONGEST_STRING:
        return
    vm.machine.say(state.typed, state.line)
    state.typed = ""


def _speed(vm: Vm, words: tuple[str, ...]) -> None:
    (value,) = _popped(vm, 1)
    set_speed(vm, value, frozenset(words))


def _tolerance(vm: Vm, operand: tuple[Any, int]) -> None:
    set_tolerance(vm, operand[0], bool(operand[1]))


def _continuous(vm: Vm, on: int) -> None:
    vm.state.settings.continuous = bool(on)


def _timer(vm: Vm, _: None) -> None:
    number, seconds = _popped(vm, 2)
    if not 0 <= number <= 15 or not number.is_integer():
        raise ProgramFault(f"there is no timer {shown(number)}; timers are 0 to 15")
    vm.state.timers[int(number)] = vm.machine.time() - seconds


def _decompose(vm: Vm, _: None) -> None:
    array, first, place = _popped(vm, 3)
    for i, number in enumerate(poses.angles(place)):
        array.element((first + i,)).value = number


def _call(vm: Vm, index: int) -> None:
    routine = vm.program.routines[index]
    if len(vm.state.frames) >= _DEEPEST_CALL:
        raise ProgramFault(f"CALL of {routine.name} more than {_DEEPEST_CALL} deep; does it call itself?")
    given = _popped(vm, routine.parameters)
    names = routine.variables
    variables = [
        value if isinstance(value, Variable) else Variable(name, _kept(value))
        for name, value in zip(names, given, strict=False)
    ]
    variables += [Variable(name) for name in names[len(given) :]]
    vm.state.frames.append(Frame(index, 0, variables, vm.state.line))


def _return(vm: Vm, _: None) -> bool:
    if len(vm.state.frames) > 1:
        vm.state.frames.pop()
        return False
    return not ending(vm, Status.HALTED) and _again(vm)


_OPERATIONS: dict[str, Callable[[Vm, Any], bool | None]] = {
    "CONST": _const,
    "LOAD_GLOBAL": _load_global,
    "LOAD_LOCAL": _load_local,
    "REF_GLOBAL": _ref_global,
    "REF_LOCAL": _ref_local,
    "ELEMENT": _element,
    "VALUE": _value,
    "ASSIGN": _assign,
    "JUMP": _jump,
    "JUMP_IF_FALSE": _jump_if_false,
    "JUMP_IF_TRUE": _jump_if_true,
    "JUMP_IF_PAST": _jump_if_past,
    "WAIT": _wait,
    "UNARY": _unary,
    "BINARY": _binary,
    "COMPOUND": _compound,
    "FUNCTION": _function,
    "ACTION": _action,
    "HERE": _here,
    "HERE_JOINTS": _here_joints,
    "SHIFT": _shift,
    "ENCODE": _encode,
    "TYPE": _type,
    "SPEED": _speed,
    "TOLERANCE": _tolerance,
    "CONTINUOUS": _continuous,
    "TIMER": _timer,
    "DECOMPOSE": _decompose,
    "CALL": _call,
    "RETURN": _return,
}
