"""Figures of drives hold what they say."""

import numpy as np
import pytest
from omni_bases import NOISE, burst, log, soccer, symmetric

from holonom.errors import InputError, OutputError, ShapeError
from holonom.mobile import arrangements
from holonom.mobile.drive.envelopes import Envelope, Limit, effective_motors
from holonom.mobile.drive.slip import SlipSettings, SlipStatus, detect_slip

pytest.importorskip("matplotlib", reason="Matplotlib is not installed; pip install -e '.[plots]'")
from holonom.plots.drive import draw_effective_motors, draw_envelopes, draw_slip


def test_effective_motors_are_drawn_by_direction_and_without_the_dead_one(tmp_path):
    base = arrangements.omni(np.deg2rad([33, 135, 225, 327]), radius=0.09, wheel_radius=0.027)
    (axes,) = draw_effective_motors(base, out=[0], save=tmp_path / "motors.png").axes
    curves = {line.get_label(): line for line in axes.lines}
    for name, out in (("all motors", ()), (f"without {base.driven[0]}", (0,))):
        phi, value = curves[name].get_data()
        np.testing.assert_allclose(value, effective_motors(base, phi, out=out))
    assert axes.get_theta_offset() == pytest.approx(np.pi / 2)  # forwards is up
    assert [t.get_text() for t in axes.texts] == list(base.driven)
    assert (tmp_path / "motors.png").stat().st_size > 10_000


def test_envelopes_say_where_the_floor_binds():
    phi = np.linspace(0, 2 * np.pi, 9)
    floor = np.where((phi > 1.0) & (phi < 4.0), Limit.FRICTION, Limit.MOTOR)[:, None].repeat(4, axis=1)
    reachable = phi < 5.0
    mixed = Envelope(phi, np.where(reachable, 2.0, 0.0), reachable, floor)
    (axes,) = draw_envelopes({"mixed": mixed}, title="acceleration", unit="m/s²").axes
    motor, rough = axes.lines
    assert motor.get_label() == "mixed"
    assert rough.get_label() == "mixed, floor binds"
    inside = (phi > 1.0) & (phi < 4.0)
    assert np.isfinite(rough.get_ydata())[inside].all()
    assert np.isnan(motor.get_ydata())[~reachable].all()  # no line where it cannot be
    assert axes.get_title() == "acceleration (m/s²)"


def test_slip_is_drawn_over_time(tmp_path):
    rng = np.random.default_rng(1)
    base = soccer(radius=0.09)
    _, m, gyro = log(rng, base, 600, {2: burst(600, 200, 400, 1.0)})
    time = 1e-3 * np.arange(600)
    report = detect_slip(base, m, SlipSettings(noise=NOISE), rate=gyro)
    residual, statistic, said = draw_slip(time, report, save=tmp_path / "slip.png").axes
    np.testing.assert_array_equal(np.array([line.get_ydata() for line in residual.lines]).T, report.residual)
    assert statistic.lines[1].get_ydata()[0] == report.threshold
    assert [t.get_text() for t in said.get_yticklabels()] == ["wheel 1", "wheel 2", "wheel 3", "wheel 4"]
    assert (report.status == SlipStatus.SLIP).any()
    full = [c for c in said.collections if c.get_alpha() != 0.25 and c.get_paths()]
    (path,) = full[0].get_paths()
    named = time[report.wheel == 2]
    np.testing.assert_allclose([path.vertices[:, 0].min(), path.vertices[:, 0].max()], [named[0], named[-1]])
    np.testing.assert_allclose(path.vertices[:, 1].mean(), 2.0, atol=0.05)
    assert len(full) == 1


def test_errors_name_the_cause(tmp_path):
    report = detect_slip(symmetric(), np.zeros((5, 4)), SlipSettings())
    with pytest.raises(ShapeError, match="time"):
        draw_slip(np.zeros(4), report)
    with pytest.raises(ShapeError, match="3 names for 4 wheels"):
        draw_slip(np.zeros(5), report, names=["a", "b", "c"])
    with pytest.raises(InputError, match="no envelope"):
        draw_envelopes({})
    with pytest.raises(OutputError, match="cannot be written"):
        draw_effective_motors(symmetric(), save=tmp_path / "figure.nonsense")
