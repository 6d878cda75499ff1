"""Options of a command: a record's fields as words of a command line."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass
from pathlib import Path

import pytest

from holonom.app.console.options import argument, option, output, parse_options, quiet, seed
from holonom.errors import UsageError


@dataclass(frozen=True, kw_only=True)
class Options:
    """One of everything."""

    map: Path = argument("map", metavar="MAP")
    others: tuple[float, ...] = argument("more", metavar="X", default=())
    from_: tuple[float, float] = option(MISSING, "start", metavar="X,Y", unit="m")
    via: tuple[float, ...] = option((), "between", metavar="X,...", least=-10.0)
    box: tuple[float, float] | None = option(None, "bounds", metavar=("LOW", "HIGH"), least=-math.inf, most=math.inf)
    gain: float = option(2.0, "gain in 100 %", above=0.0)
    laps: int = option(1, "laps", least=-2)
    colour: str | None = option(None, "colour", choices=("red", "green"))
    fast: bool = option(False, "fast", either="pace")
    slow: bool = option(False, "slow", either="pace")
    output: Path | None = output("here")
    quiet: bool = quiet()
    seed: int | None = seed(None, "of noise")


def parse(*words: str) -> Options:
    found = parse_options(Options, words, prog="holonom plan", description="a plan")
    assert isinstance(found, Options)
    return found


@pytest.mark.parametrize("words", [("--from", "-1,5"), ("--from=-1,5",)])
def test_a_negative_number_is_a_value(words: tuple[str, ...]) -> None:
    assert parse("m", *words).from_ == (-1.0, 5.0)
    assert parse(*words, "m", "-3", "-1e3", "-.5").others == (-3.0, -1e3, -0.5)
    assert parse("m", *words, "--box", "-inf", "-1e3").box == (-math.inf, -1000.0)
    assert parse("m", *words, "--laps", "-1").laps == -1
    assert parse("m", *words, "--via", "-1,-2.5,3e-1").via == (-1.0, -2.5, 0.3)
    assert parse("-1.map", *words, "-o", "-2").output == Path("-2")
    assert parse("-1.map", *words).map == Path("-1.map")


def test_defaults_and_switches() -> None:
    plain = parse("m", "--from", "0,0")
    assert plain == Options(map=Path("m"), from_=(0.0, 0.0))
    assert (plain.others, plain.via, plain.box, plain.gain, plain.quiet, plain.seed) == ((), (), None, 2.0, False, None)
    assert parse("m", "--from", "0,0", "-q", "--fast", "--seed", "4").seed == 4
    assert parse("m", "--from", "0,0", "--json").quiet
    assert parse("--from", "0,0", "--", "--map").map == Path("--map")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--from", "1"), "--from has 1 entries; 2 are needed"),
        (("--from", "1,x"), "--from is 'x'; it must be a number"),
        (("--from", "1,nan"), "--from is nan; it must be finite m"),
        (("--from", "1,inf"), "--from is inf; it must be finite m"),
        (("--from", "-1,-2", "--via", "-11"), "--via is -11.0; it must be finite and at least -10"),
        (("--from", "0,0", "--gain", "-1"), "--gain is -1.0; it must be finite and greater than 0"),
        (("--from", "0,0", "--gain", "0"), "--gain is 0.0; it must be finite and greater than 0"),
        (("--from", "0,0", "--gain", "-inf"), "--gain is -inf; it must be finite and greater than 0"),
        (("--from", "0,0", "--laps", "-3"), "--laps is -3; it must be finite and at least -2"),
        (("--from", "0,0", "--laps", "2.0"), "--laps is '2.0'; it must be a whole number"),
        (
            ("--from", "0,0", "--colour", "gren"),
            "no value of --colour 'gren'; there is green, red; did you mean 'green'",
        ),
        (("--from", "0,0", "--fast", "--slow"), "--slow: not allowed with argument --fast"),
        (("--from", "0,0", "--from_"), "no option of holonom plan '--from_'"),
        ((), "required: --from"),
    ],
)
def test_what_does_not_fit(words: tuple[str, ...], said: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse("m", *words)
    assert said in str(caught.value)
    assert "\0" not in str(caught.value)


def test_help_says_meaning_default_and_choices(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        parse("--help")
    assert caught.value.code == 0
    text = capsys.readouterr().out
    for said in (
        "usage: holonom plan",
        "--from X,Y",
        "--box LOW HIGH",
        "gain in 100 %, 2.0 unless given",
        "{red,green}",
    ):
        assert said in text
