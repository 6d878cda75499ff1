"""Tables of methods: lookup, parameters, and what other packages add by entry points."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from holonom.errors import InputError, OutOfLimits, UnknownName
from holonom.registry import Method, NoParams, Table, check_fields, parameter, parameters_of, read_record


@dataclass(frozen=True, slots=True)
class Params:
    """One field of each type."""

    gain: float = parameter(meaning="gain", unit="1/s", above=0.0, example=1.0)
    delay: float = parameter(0.0, meaning="delay", unit="s", least=0.0, most=2.0)
    reset: float = parameter(math.inf, meaning="reset time", unit="s", above=0.0, most=math.inf)
    order: int = parameter(1, meaning="order", least=1, below=4)
    filtered: bool = parameter(False, meaning="whether it is filtered")
    side: str = parameter("left", meaning="side", choices=("left", "right"))
    start: tuple[float, float] = parameter((0.0, 0.0), meaning="start", unit="m")
    limit: float | None = parameter(None, meaning="limit", least=-1.0)
    name: str = "not a parameter"

    def __post_init__(self) -> None:
        check_fields(self)


LAWS = Table(
    "laws",
    "law",
    "its params",
    {
        "straight": Method("straight on", lambda params: params, "a book", Params),
        "plain": Method("without parameters", lambda params: "made", "a book"),
        "lazy": "test_registry_lazy:METHOD",
    },
)


def test_values_become_a_record() -> None:
    made = LAWS.make("straight", {"gain": 2, "start": [1, 2.5], "order": 3, "limit": None})
    assert made == Params(gain=2.0, start=(1.0, 2.5), order=3)
    assert isinstance(made.gain, float)
    assert isinstance(made.start[0], float)
    assert LAWS.make("plain") == "made"
    assert LAWS.params("plain", {}) == NoParams()
    assert [f.name for f in parameters_of(Params) if f.required] == ["gain"]


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({}, InputError, "law 'straight': gain missing; it needs gain (gain)"),
        ({"gain": 1, "gian": 1}, UnknownName, "no parameter of law 'straight' 'gian'; there is delay, filtered, gain,"),
        ({"gain": 0}, OutOfLimits, "law 'straight': gain is 0.0; it must be finite and greater than 0 1/s"),
        ({"gain": math.nan}, OutOfLimits, "gain is nan"),
        ({"gain": math.inf}, OutOfLimits, "gain is inf"),
        ({"gain": "2"}, InputError, "gain is '2'; it must be a number"),
        ({"gain": True}, InputError, "gain is True; it must be a number"),
        ({"gain": None}, InputError, "gain is None; it must be a number"),
        ({"gain": 1, "delay": 2.5}, OutOfLimits, "delay is 2.5; it must be 0 to 2 s"),
        ({"gain": 1, "reset": math.nan}, OutOfLimits, "reset is nan; it must be greater than 0 and may be infinite s"),
        ({"gain": 1, "order": 4}, OutOfLimits, "order is 4; it must be finite and at least 1 and less than 4"),
        ({"gain": 1, "order": 1.0}, InputError, "order is 1.0; it must be a whole number"),
        ({"gain": 1, "order": True}, InputError, "order is True; it must be a whole number"),
        ({"gain": 1, "filtered": 1}, InputError, "filtered is 1; it must be true or false"),
        ({"gain": 1, "side": "lef"}, UnknownName, "did you mean 'left'?"),
        ({"gain": 1, "start": [1.0]}, InputError, "start has 1 entries; 2 are needed"),
        ({"gain": 1, "start": 1.0}, InputError, "start is 1.0; it must be a list"),
        ({"gain": 1, "start": [1.0, math.nan]}, OutOfLimits, "start is nan; it must be finite m"),
        ({"gain": 1, "limit": -2.0}, OutOfLimits, "limit is -2.0; it must be finite and at least -1"),
        ({"gain": 1, "name": "x"}, UnknownName, "no parameter of law 'straight' 'name'"),
    ],
)
def test_faults_are_worded(given: dict[str, Any], error: type[InputError], said: str) -> None:
    with pytest.raises(error, match=re.escape(said)) as caught:
        LAWS.params("straight", given)
    assert type(caught.value) is error


def test_a_method_without_parameters_says_so() -> None:
    with pytest.raises(UnknownName, match="no parameter of law 'plain' 'x'; there is none"):
        LAWS.make("plain", {"x": 1})


def test_a_record_checks_itself() -> None:
    assert Params(gain=1.0, reset=math.inf).reset == math.inf
    with pytest.raises(OutOfLimits, match="Params: delay is -1"):
        Params(gain=1.0, delay=-1.0)
    assert read_record(Params, {"gain": 3}, "x").gain == 3.0


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownName, match="no law 'strait'; there is lazy, plain, straight; did you mean 'straight'"):
        LAWS["strait"]
    assert "plain" in LAWS
    assert "strait" not in LAWS
    assert len(LAWS) == 3


def test_a_line_is_imported_when_it_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(LAWS) == ["straight", "plain", "lazy"]  # although its module is not there
    source = "from holonom.registry import Method\nMETHOD = Method('late', lambda params: 7, 'a book')\n"
    (tmp_path / "test_registry_lazy.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    assert LAWS.make("lazy") == 7


def install(folder: Path, monkeypatch: pytest.MonkeyPatch, package: str, source: str, *points: str) -> None:
    """Lay a package of one module with entry points of `holonom.laws` into a folder of the module search path."""
    (folder / f"{package}.py").write_text(source)
    about = folder / f"{package}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("\n".join(["[holonom.laws]", *points, ""]))
    monkeypatch.syspath_prepend(folder)


LAW = """
from holonom.registry import Method
METHOD = Method("wavy", lambda params: "wave", "a paper")
WRONG = "no method"
"""
OWN_LINES = {"plain": LAWS["plain"]}


def laws() -> Table:
    return Table("laws", "law", "a word", OWN_LINES)


def test_a_package_adds_a_method(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path, monkeypatch, "wavy_laws", LAW, "wavy = wavy_laws:METHOD")
    assert list(laws()) == ["plain", "wavy"]
    assert laws().make("wavy") == "wave"
    assert laws().own == ("plain",)
    with pytest.raises(UnknownName, match="there is plain, wavy; did you mean 'wavy'"):
        laws()["wavvy"]


@pytest.mark.parametrize(
    ("point", "said"),
    [
        ("wavy = wavy_laws:ABSENT", "law 'wavy' = wavy_laws:ABSENT of wavy_laws cannot be loaded: AttributeError: "),
        ("wavy = absent_module:METHOD", "law 'wavy' = absent_module:METHOD of wavy_laws cannot be loaded: ModuleNot"),
        ("wavy = wavy_laws:WRONG", "law 'wavy' = wavy_laws:WRONG of wavy_laws is a str; it must be a "),
        ("plain = wavy_laws:METHOD", "more than one law is called 'plain': Holonom's own, 'plain' = wavy_laws:METHOD"),
    ],
)
def test_a_package_that_is_wrong_is_named(
    point: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path, monkeypatch, "wavy_laws", LAW, point)
    name = point.partition(" ")[0]
    with pytest.raises(InputError, match=re.escape(said)):
        laws()[name]
    found, problems = laws().survey()
    assert list(found) == [known for known in OWN_LINES if known != name]
    assert len(problems) == 1
    assert said in problems[0]


def test_two_packages_with_one_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("wavy_laws", "other_laws"):
        (tmp_path / package).mkdir()
        install(tmp_path / package, monkeypatch, package, LAW, f"wavy = {package}:METHOD")
    with pytest.raises(InputError, match=r"more than one law is called 'wavy': .* of other_laws, .* of wavy_laws"):
        laws()["wavy"]
