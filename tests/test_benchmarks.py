"""Every benchmark runs once, small; nothing is said about time."""

import json

import pytest

from holonom.app.about.bench import Figure, run_benchmarks
from holonom.app.console.cli import main
from holonom.errors import UnknownName


@pytest.mark.oracle
def test_every_benchmark_runs(tmp_path, capsys):
    assert main(["bench", "--small", "--json", "-o", str(tmp_path)]) == 0
    figures = json.loads(capsys.readouterr().out)["figures"]
    assert json.loads((tmp_path / "bench.json").read_text())["figures"] == figures
    names = " ".join(f["what"] for f in figures)
    for verb in (
        "inverse dynamics",
        "forward dynamics",
        "forward kinematics",
        "inverse branches",
        "numerical inverse",
        "one call, arm.ik",
        "one call, arm.ik_nearest",
        "one call, solve_inverse",
        "one call, forward_dynamics_derivatives",
        "one call, joint_rates",
        "one call, Puma, kernel.single",
        "two threads",
        "six axes",
        "axis at 10 kHz",
    ):
        assert verb in names
    assert all(f["ours"] > 0.0 for f in figures)
    assert all((f["ratio"] is None) == (f["peer"] is None) for f in figures)


def test_ratios_point_the_right_way():
    assert Figure("a", 2.0, "ns", "peer", 8.0).ratio == 4.0
    assert Figure("a", 8.0, "x real time", "peer", 2.0, more_is_better=True).ratio == 4.0
    assert Figure("a", 2.0, "ns", "peer").ratio is None


def test_an_unknown_benchmark_is_named():
    with pytest.raises(UnknownName, match="kinematics"):
        run_benchmarks(["kinematic"])
