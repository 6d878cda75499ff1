"""docs/arps.md says what the language does: its tables are those of the code, its examples run."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from arps_machine import FakeMachine, run, said, wrap

from holonom.errors import ProgramError
from holonom.lang import (
    FEATURES,
    FORMATS,
    FUNCTIONS,
    INSTRUCTIONS,
    WORDS,
    Part,
    Status,
    compile_program,
    load_program,
    poses,
    read_locations,
)

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "arps.md").read_text("utf-8")
FENCES = re.findall(r"^```(arps|typed|wrong|message)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def coin(x: float, diameter: float) -> Part:
    area = np.pi * diameter**2 / 4e6
    pose = poses.transformation((x, -100, 300, 0, 180, 0))
    return Part("coin", pose, (1.0, x / 1e3, -0.1, 0.0, area, diameter / 1e3))


def pairs(first: str, second: str) -> list[tuple[str, str]]:
    """Blocks of the kind `first` that are followed by one of the kind `second`."""
    return [(a[1], b[1]) for a, b in pairwise(FENCES) if (a[0], b[0]) == (first, second)]


def test_every_example_states_what_it_types() -> None:
    assert len(pairs("arps", "typed")) == sum(kind == "arps" for kind, _ in FENCES) >= 7


@pytest.mark.parametrize(("source", "typed"), pairs("arps", "typed"))
def test_example(source: str, typed: str) -> None:
    assert said(source, FakeMachine(motion_ticks=2, parts=[coin(450, 20), coin(480, 25)])) == typed.splitlines()


@pytest.mark.parametrize(("source", "text"), pairs("wrong", "message"))
def test_message(source: str, text: str) -> None:
    with pytest.raises(ProgramError) as caught:
        compile_program(wrap(source), "job.arps")
    assert str(caught.value) == text.rstrip()


@pytest.mark.parametrize("builtin", [*INSTRUCTIONS.values(), *FUNCTIONS.values()], ids=lambda b: b.name)
def test_table_row(builtin) -> None:  # type: ignore[no-untyped-def]
    assert f"| `{builtin.usage}` | {builtin.help} |" in PAGE


def test_features_formats_and_words() -> None:
    assert all(f"| {n} | {meaning} |" in PAGE for n, (meaning, _) in FEATURES.items())
    assert all(f"- {help}" in PAGE for help in FORMATS.values())
    assert [word for word in WORDS if not re.search(rf"\b{re.escape(word)}\b", PAGE)] == []


def test_what_is_said_to_be_missing_is_an_error() -> None:
    missing = re.findall(r"`(\w+)`", PAGE.split("## Not there yet")[1].split("All numbers")[0])
    assert len(missing) > 8
    for word in missing:
        with pytest.raises(ProgramError, match=f"there is no instruction '{word}'"):
            compile_program(wrap(f"{word} 1"))


def test_sort_coins_puts_each_coin_into_its_field() -> None:
    """18 small, 2 medium, 4 large, in a mixed order: each goes to its own place of the right field."""
    sizes = [20.0] * 9 + [28.0, 25.0] * 2 + [24.3] * 9 + [26.5, 31.0]
    machine = FakeMachine(motion_ticks=2, hand_ticks=3, parts=[coin(450 + i, d) for i, d in enumerate(sizes)])
    program = load_program(ROOT / "examples" / "01_sort_coins" / "sort_coins.arps")
    _, state = run(program, machine, ticks=5000)
    assert state.status is Status.HALTED
    assert [text for text, _ in machine.said] == ["The camera sees 24 coins.", "small: 18", "medium: 2", "large: 4"]
    lowered = [m.pose[:3, 3] for m in machine.motions if m.kind == "line" and m.pose is not None and m.speed == 0.5]
    taken, put = np.array(lowered[::2]), np.array(lowered[1::2])
    assert taken[:, 0] == pytest.approx(0.45 + 0.001 * np.arange(24))
    corners = _corners()
    for size, place in zip(sizes, put, strict=True):
        field = "small" if size < 24.35 else "medium" if size < 26.4 else "large"
        columns = {"small": 6, "medium": 2, "large": 2}[field]
        column, row = np.round((place - corners[field])[:2] / 0.036, 6)
        assert (column.is_integer(), row.is_integer()) == (True, True)
        assert 0 <= column < columns
        assert 0 <= row < {"small": 3, "medium": 1, "large": 2}[field]
    assert len({tuple(np.round(p, 6)) for p in put}) == 24
    closed = [entry[1] for entry in machine.log if entry[0] == "hand"]
    assert closed == [False] + [True, False] * 24
    assert [e for e in machine.log if e[0] == "signal"] == (
        [("signal", 1, True)] + [("signal", 2, True), ("signal", 2, False)] * 24 + [("signal", 1, False)]
    )


def _corners() -> dict[str, np.ndarray]:
    path = ROOT / "examples" / "01_sort_coins" / "sort_coins.loc"
    found = read_locations(path.read_text("utf-8"), str(path))
    return {name: found[f"tray.{name}"][:3, 3] for name in ("small", "medium", "large")}


def test_straight_lines_draws_a_square_and_a_circle_twice() -> None:
    program = load_program(ROOT / "examples" / "02_straight_lines" / "straight_lines.arps")
    machine, state = run(program, FakeMachine(motion_ticks=2), ticks=5000)
    assert state.status is Status.HALTED
    signals = [(e[1], e[2]) for e in machine.log if e[0] == "signal"]
    assert signals == [(n, on) for n in (1, 2, 3, 4) for on in (True, False)]
    lines = [m for m in machine.motions if m.kind == "line"]
    assert [m.speed_mps for m in lines] == [0.1] * 28 + [0.25] * 28
    ends = np.array([m.pose[:3, 3] for m in lines])
    start = machine.motions[1].pose[:3, 3]
    sides = np.linalg.norm(np.diff(ends[:4], axis=0, prepend=start[None]), axis=1)
    assert sides == pytest.approx([0.2] * 4)
    assert ends[3] == pytest.approx(start)
    centre = ends[:4].mean(0)
    assert np.linalg.norm(ends[4:28] - centre, axis=1) == pytest.approx([0.1] * 24)
    assert np.linalg.norm(np.diff(ends[4:28], axis=0), axis=1) == pytest.approx([0.2 * np.sin(np.pi / 24)] * 23)
    assert all(m.blend for m in lines)
