"""`holonom bench drive`: one arrangement, one law, briefly; words that are wrong."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.app.about.drive_bench.driven import KEEPING
from holonom.app.console.cli import main
from holonom.control import PATH_LAWS
from holonom.mobile.methods import ARRANGEMENTS


def test_one_arrangement_and_one_law(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "drive", "differential", "segway", "--laws", "stanley", "--small"]
    assert main([*words, "--json", "-o", str(tmp_path)]) == 0
    data = json.loads(capsys.readouterr().out)
    assert json.loads((tmp_path / "drive_bench.json").read_text("utf-8")) == data
    row, other = data["driven"]
    assert (row["arrangement"], row["law"], row["course"]) == ("differential", "stanley", "straight")
    assert 0.0 < row["rms"] < row["peak"] < 0.02
    assert 5.0 < row["time"] < 8.0
    assert 0.5 < row["effort"] < 0.5 * 8.0 * 1.0**2, "braking gives back a part of what its motion holds"
    assert {(g["run"], g["cause"]) for g in data["growth"] if g["arrangement"] == "differential"} == {
        (run, cause) for run in ("straight", "square", "spin") for cause in ("radius", "slip", "mounting")
    }
    assert main([*words, "--markdown", "-q"]) == 0
    page = capsys.readouterr().out
    assert f"| differential | stanley | {1e3 * row['rms']:.1f} / {1e3 * row['peak']:.1f} |" in page
    assert not other["failed"]
    assert f"| segway | stanley | {1e3 * other['rms']:.1f} / {1e3 * other['peak']:.1f} |" in page


@pytest.mark.parametrize(
    ("words", "said"), [(("sofa",), "no arrangement 'sofa'"), (("omni", "--laws", "hope"), "no law of a path 'hope'")]
)
def test_wrong_words(words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "drive", *words]) == 2
    assert said in capsys.readouterr().err


def test_a_law_that_is_not_for_an_arrangement(capsys: pytest.CaptureFixture[str]) -> None:
    """It is said; where nothing is left to drive it is a mistake."""
    aside = ["synchro", "omni", "mecanum", "swerve", "sphere"]
    assert main(["bench", "drive", *aside, "--laws", "stanley"]) == 2
    said = capsys.readouterr().err
    assert f"--laws stanley: not for {', '.join(aside)}, which move sideways" in said
    assert "leave --laws out" in said
    assert main(["bench", "drive", "omni", "differential", "--laws", "stanley", "--small", "-q"]) == 0
    printed = capsys.readouterr().out
    assert "note: stanley: not for omni, which move sideways" in printed
    assert "differential  stanley" in printed


def test_bench_alone_stays_a_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "nothing_of_the_kind"]) == 2
    assert "no benchmark 'nothing_of_the_kind'" in capsys.readouterr().err


@pytest.mark.oracle
def test_everything_briefly(capsys: pytest.CaptureFixture[str]) -> None:
    """Every law on every arrangement, once, along a straight."""
    pytest.importorskip("osqp", reason="OSQP is not installed; pip install -e '.[mpc]'")
    assert main(["bench", "drive", "--small", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["driven"]
    assert {row["arrangement"] for row in rows} == set(BASES)
    assert {row["law"] for row in rows} == {*PATH_LAWS, KEEPING}
    assert all(row["rms"] < 0.02 and not row["failed"] for row in rows)


def test_there_is_a_base_of_every_arrangement() -> None:
    assert set(BASES) == set(ARRANGEMENTS.own)
