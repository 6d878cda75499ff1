"""Sine and cosine: interpolation, its errors, and Heydemann's correction."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from holonom.devices import (
    SinCosCorrection,
    SinCosEncoder,
    correct_sincos,
    fine_angle,
    fit_heydemann,
    interpolate,
    quarter_of,
    sincos_signals,
)
from holonom.errors import CalibrationError, ModelError, NotFinite

IDEAL = SinCosEncoder(2048)
ERRORS = st.builds(
    lambda s, c, g, p: SinCosEncoder(2048, 0.5, s, c, g, p),
    st.floats(-0.1, 0.1),
    st.floats(-0.1, 0.1),
    st.floats(0.8, 1.25),
    st.floats(-0.2, 0.2),
)


def signals(encoder: SinCosEncoder, angles: np.ndarray) -> np.ndarray:
    return np.array([sincos_signals(encoder.params(), float(a)) for a in angles]).T


@given(st.floats(-1e3, 1e3))
def test_the_arctangent_inverts_ideal_signals(angle: float) -> None:
    params = IDEAL.params()
    found = fine_angle(params, quarter_of(params, angle), *sincos_signals(params, angle))
    assert found == pytest.approx(angle, abs=1e-12)


@given(angle=st.floats(-50.0, 50.0), encoder=ERRORS, off=st.sampled_from([-1, 0, 1]))
def test_a_count_beside_the_right_one_does_no_harm(angle: float, encoder: SinCosEncoder, off: int) -> None:
    params = encoder.params()
    found = fine_angle(params, quarter_of(params, angle) + off, *sincos_signals(params, angle))
    assert abs(found - angle) <= encoder.largest_error() * (1.0 + 1e-3) + 1e-12


@given(ERRORS)
def test_the_largest_error_is_reached_and_not_exceeded(encoder: SinCosEncoder) -> None:
    angles = (np.arange(600) + 0.37) * math.tau / 600 / 2048
    params = encoder.params()
    errors = [fine_angle(params, quarter_of(params, a), *sincos_signals(params, a)) - a for a in angles.tolist()]
    assert max(map(abs, errors)) == pytest.approx(encoder.largest_error(), rel=2e-3, abs=1e-12)


@pytest.mark.parametrize(
    ("errors", "first_order"),
    [
        ({"sine_offset": 1e-3}, 1e-3),
        ({"cosine_offset": -1e-3}, 1e-3),
        ({"gain_ratio": 1.001}, 5e-4),
        ({"phase_error": 1e-3}, 1e-3),
    ],
)
def test_small_errors_are_those_of_the_first_order(errors: dict[str, float], first_order: float) -> None:
    assert SinCosEncoder(2048, **errors).largest_error() == pytest.approx(first_order / 2048, rel=2e-3)


def test_the_published_error(data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    case = next(case for case in cases if case["id"].startswith("sin/cos"))
    encoder = SinCosEncoder(case["input"]["lines"], sine_offset=case["input"]["offset"])
    assert encoder.largest_error() == pytest.approx(case["expected"]["largest_error_rad"], rel=case["tol"])


@given(ERRORS)
def test_heydemann_takes_the_errors_away(encoder: SinCosEncoder) -> None:
    angles = np.sort(np.random.default_rng(5).uniform(0.0, math.tau / 2048, 60))
    correction = fit_heydemann(*signals(encoder, angles))
    assert correction.gain_ratio == pytest.approx(encoder.gain_ratio, abs=1e-9)
    assert correction.phase_error == pytest.approx(encoder.phase_error, abs=1e-9)
    assert correction.sine_offset == pytest.approx(0.5 * encoder.sine_offset, abs=1e-9)
    assert correction.cosine_offset == pytest.approx(0.5 * encoder.cosine_offset, abs=1e-9)
    for angle, sine, cosine in zip(angles, *signals(encoder, angles), strict=True):
        phase = interpolate(*correct_sincos(correction, sine, cosine))
        assert math.remainder(phase - 2048 * angle, math.tau) == pytest.approx(0.0, abs=1e-8)


def test_heydemann_with_noise_is_far_better_than_none() -> None:
    encoder = SinCosEncoder(2048, 0.5, 0.02, -0.03, 1.05, 0.04)
    random = np.random.default_rng(6)
    angles = random.uniform(0.0, math.tau, 2000)
    noisy = signals(encoder, angles) + random.normal(0.0, 5e-4, (2, 2000))
    correction = fit_heydemann(*noisy)
    left = [
        abs(math.remainder(interpolate(*correct_sincos(correction, s, c)) - 2048 * a, math.tau))
        for a, s, c in zip(angles, *signals(encoder, angles), strict=True)
    ]
    assert max(left) < 1e-3 < 0.02 * 2048 * encoder.largest_error()


def test_no_correction_changes_nothing() -> None:
    assert correct_sincos(SinCosCorrection(), 0.3, -0.4) == (0.3, -0.4)


def test_converters_of_few_bits_see_no_finer() -> None:
    """Independent: both signals rounded to the converter's steps, along a whole line."""
    encoder = SinCosEncoder(16)
    angles = np.linspace(0.0, math.tau / 16, 40_000)
    steps = 2.0 * encoder.amplitude / 2**8
    sine, cosine = steps * np.round(encoder.amplitude * np.array([np.sin(16 * angles), np.cos(16 * angles)]) / steps)
    seen = np.unique(np.arctan2(sine, cosine)) / 16
    assert np.diff(seen).max() == pytest.approx(encoder.resolution(8), rel=0.01)


HALF = np.linspace(0.0, 0.3, 50)


@pytest.mark.parametrize(
    ("make", "error", "named"),
    [
        (lambda: SinCosEncoder(0), ModelError, "lines is 0"),
        (lambda: SinCosEncoder(10, sine_offset=0.7), ModelError, "sine_offset is 0.7"),
        (lambda: SinCosEncoder(10, phase_error=math.nan), ModelError, "phase_error is nan"),
        (lambda: IDEAL.resolution(1), ModelError, "bits is 1"),
        (lambda: fit_heydemann(np.zeros(5), np.zeros(5)), CalibrationError, "5 sines and 5 cosines; 8 of each"),
        (lambda: fit_heydemann(np.zeros(9), np.zeros(10)), CalibrationError, "9 sines and 10 cosines"),
        (lambda: fit_heydemann(np.zeros(9), np.zeros(9)), CalibrationError, "all signals are 0"),
        (lambda: fit_heydemann(np.ones(9), np.ones(9)), CalibrationError, "too little of one"),
        (lambda: fit_heydemann(np.sin(HALF), np.cos(HALF)), CalibrationError, "too little of one"),
        (lambda: fit_heydemann(np.sinh(HALF * 9), np.cosh(HALF * 9)), CalibrationError, "on no ellipse"),
        (lambda: fit_heydemann(np.full(9, np.nan), np.ones(9)), NotFinite, "sine"),
    ],
)
def test_bad_input_is_named(make: object, error: type[Exception], named: str) -> None:
    with pytest.raises(error, match=named):
        make()  # type: ignore[operator]
