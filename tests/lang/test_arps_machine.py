"""The virtual machine: waiting, stopping, copies, runaway programs, and every word of its tables."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from arps_machine import FakeMachine, run, wrap
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.errors import ProgramFault, RunawayProgram
from holonom.lang import (
    FUNCTIONS,
    INSTRUCTIONS,
    Status,
    compile_program,
    poses,
    proceed,
    start,
    step,
)

JOB = """
.PROGRAM main()
  SPEED 50 ALWAYS
  FOR i = 1 TO 4
    CALL once(i, total)
    x[i] = RANDOM
  END
  TYPE total, x[4]
.END
.PROGRAM once(n, sum)
  MOVE TRANS(n * 10, 0, 0)
  IF n == 1 THEN
    sum = 0
  END
  CLOSEI
  DELAY 0.03
  sum = sum + RANDOM
  SIGNAL n
  OPENI
  MOVES TRANS(0, n, 0)
.END
"""


def test_program_runs_ahead_until_the_queue_is_full() -> None:
    program = compile_program(wrap("\n".join(f"MOVE TRANS({i})" for i in range(4))))
    state, machine = start(program), FakeMachine(motion_ticks=3, depth=2)
    taken = []
    for _ in range(9):
        step(program, state, machine)
        taken.append((len(machine.motions), state.line))
        machine.tick()
    assert taken == [(2, 4)] * 3 + [(3, 5)] * 3 + [(4, 6)] * 3


def test_status_and_line_can_be_read() -> None:
    program = compile_program(wrap("x = 1\nWAIT SIG(4)\nTYPE x"))
    state, machine = start(program), FakeMachine()
    assert step(program, state, machine) is Status.WAITING
    assert state.line == 3
    machine.inputs.add(4)
    assert step(program, state, machine) is Status.HALTED
    assert machine.said == [("1", 4)]


def test_end_of_program_waits_for_the_arm() -> None:
    machine, state = run("MOVE NULL", FakeMachine(motion_ticks=7))
    assert (state.status, machine.ticks, machine.idle()) == (Status.HALTED, 7, True)


def test_break_and_hand_wait_for_each_other() -> None:
    machine, _ = run("MOVE NULL\nCLOSEI\nMOVE NULL\nBREAK\nSIGNAL 1", FakeMachine(motion_ticks=5, hand_ticks=4))
    assert machine.log == [("move", 2), ("hand", True, True), ("move", 4), ("signal", 1, True)]
    assert machine.ticks == 5 + 4 + 5


def test_hand_at_once_does_not_wait() -> None:
    machine, _ = run("MOVE NULL\nCLOSE\nOPEN\nRELAX\nOPENI", FakeMachine(motion_ticks=5))
    assert machine.log[1:] == [("hand", c, False) for c in (True, False, False)] + [("hand", False, True)]


def test_delay_begins_when_the_arm_is_at_rest() -> None:
    machine, _ = run("MOVE NULL\nDELAY 0.2\nMOVE NULL", FakeMachine(motion_ticks=5))
    assert machine.ticks == 5 + 20 + 5


def test_timer_counts_the_time_of_the_machine() -> None:
    machine, _ = run("TIMER 1 = 2\nDELAY 0.5\nTYPE /F0.2, TIMER(1)")
    assert machine.said == [("2.50", 4)]


def test_signals_and_waiting_for_them() -> None:
    machine, state = run("SIGNAL 1, 2, -1\nTYPE SIG(1), SIG(2), SIG(-1, 2)\nRESET\nTYPE SIG(2)\nWAIT.SIGNAL 5, -2")
    assert [text for text, _ in machine.said] == ["0-1-1", "0"]
    assert machine.log[-1] == ("signal", 2, False)
    assert state.status is Status.WAITING


def test_pause_and_proceed() -> None:
    program = compile_program(wrap('MOVE NULL\nPAUSE\nTYPE "on"'))
    machine, state = run(program, FakeMachine(motion_ticks=4))
    assert (state.status, machine.ticks, machine.said) == (Status.PAUSED, 4, [])
    assert step(program, state, machine) is Status.PAUSED
    proceed(state)
    assert step(program, state, machine) is Status.HALTED
    assert machine.said == [("on", 4)]
    proceed(state)
    assert state.status is Status.HALTED


@pytest.mark.parametrize("word", ["HALT", "STOP", "RETURN"])
def test_the_program_ends(word: str) -> None:
    machine, state = run(f'{word}\nTYPE "never"')
    assert (state.status, machine.said) == (Status.HALTED, [])


def test_entry_may_be_chosen() -> None:
    program = compile_program(JOB + '.PROGRAM other()\nTYPE "other"\n.END')
    machine = FakeMachine()
    step(program, start(program, entry="OTHER"), machine)
    assert machine.said[0][0] == "other"
    with pytest.raises(ProgramFault, match="no program 'none'; there is main, once, other"):
        start(program, entry="none")
    with pytest.raises(ProgramFault, match="once takes parameters"):
        start(program, entry="once")


def test_random_numbers_come_from_the_generator() -> None:
    program = compile_program(wrap("TYPE /F0.12, RANDOM"))
    machine = FakeMachine()
    step(program, start(program, rng=np.random.default_rng(7)), machine)
    assert float(machine.said[0][0]) == pytest.approx(np.random.default_rng(7).random(), abs=1e-11)


@given(st.integers(0, 60))
@settings(max_examples=20, deadline=None)
def test_a_run_from_a_copy_goes_the_same_way(ticks: int) -> None:
    program = compile_program(JOB)
    machine, state = FakeMachine(motion_ticks=3, hand_ticks=2), start(program)

    def advance(state, machine, count):  # type: ignore[no-untyped-def]
        for _ in range(count):
            step(program, state, machine)
            machine.tick()

    advance(state, machine, ticks)
    kept_machine, kept = copy.deepcopy(machine), state.copy()
    advance(state, machine, 100)
    assert state.status is Status.HALTED
    advance(kept, kept_machine, 100)
    assert kept_machine.said == machine.said
    assert kept_machine.log == machine.log


def test_references_stay_shared_within_a_copy() -> None:
    program = compile_program(
        ".PROGRAM m()\na = 1\nCALL f(a)\nTYPE a\n.END\n.PROGRAM f(b)\nWAIT SIG(1)\nb = b + 1\n.END"
    )
    state, machine = start(program), FakeMachine()
    step(program, state, machine)
    copied = state.copy()
    machine.inputs.add(1)
    step(program, copied, machine)
    step(program, state, machine)
    assert [text for text, _ in machine.said] == ["2", "2"]


def test_runaway_is_named_with_its_line() -> None:
    with pytest.raises(RunawayProgram, match=r":3: a loop that neither moves nor waits: 1000 operations in 10 ticks"):
        run("WHILE TRUE DO\nx = 1\nEND", budget=100, patience=10)


def test_long_work_is_no_runaway() -> None:
    source = "FOR i = 1 TO 30\nFOR j = 1 TO 50\nx = j\nEND\nDELAY 0.01\nEND\nTYPE i"
    machine, _ = run(source, budget=100, patience=10)
    assert machine.said == [("31", 8)]


def test_a_loop_of_motions_is_no_runaway() -> None:
    machine, _ = run("FOR i = 1 TO 300\nMOVE NULL\nEND", budget=20, patience=5)
    assert len(machine.motions) == 300


def test_program_is_frozen() -> None:
    program = compile_program(JOB)
    with pytest.raises(AttributeError):
        program.file = "x"  # type: ignore[misc]
    before = repr(program)
    run(program)
    assert repr(program) == before


SAMPLES = {"real": "1", "string": '"1"', "location": "p", "target": "p", "new location": "p", "variable": "p"}


@pytest.mark.parametrize("name", INSTRUCTIONS)
def test_every_instruction_of_the_table_runs(name: str) -> None:
    instruction = INSTRUCTIONS[name]
    values = ", ".join(SAMPLES[p.kind] for p in instruction.parameters)
    machine = FakeMachine(inputs={1})
    _, state = run(f'SET p = TRANS(1)\n{name} {values}\nTYPE "after"', machine)
    ends = name in ("HALT", "STOP", "PAUSE")
    assert [text for text, _ in machine.said] == ([] if ends else ["after"])
    assert state.stack == []


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_of_the_table_gives_what_it_says(name: str) -> None:
    function = FUNCTIONS[name]
    points = iter(("NULL", "TRANS(1)", "TRANS(0, 1)", "NULL"))
    values = [next(points) if p.kind == "location" else SAMPLES[p.kind] for p in function.parameters]
    values *= 6 if name == "#PPOINT" else 1
    call = f"{name}({', '.join(values)})" if values else name
    use = {"real": "TYPE {}", "string": "TYPE {}", "location": "MOVE {}", "joints": "MOVE {}"}[function.result]
    machine, _ = run("TIMER 1 = 0\nVPICTURE\n" + use.format(call))
    assert len(machine.said) + len(machine.motions) == 1


def test_location_values_are_not_shared_with_the_machine() -> None:
    machine, _ = run("SET a = TRANS(1)\nMOVE a\nMOVE a")
    machine.motions[0].pose[0, 3] = 5.0
    assert machine.motions[1].pose[0, 3] == 0.001
    assert poses.angles(machine.motions[1].pose)[0] == 1.0
