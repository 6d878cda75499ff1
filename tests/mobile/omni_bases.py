"""Drives and logs for the tests of specification 6.2."""

import numpy as np

from holonom.mobile.drive.coupling import Coupling, omni_coupling, rim_speeds

NOISE = 0.02  # m/s
RATE_NOISE = 0.01  # rad/s


def symmetric(degrees: float = 37.5, **body: float) -> Coupling:
    """Four wheels whose motor axes lie at an angle to the x axis."""
    a = np.deg2rad(degrees)
    return omni_coupling([a, np.pi - a, np.pi + a, -a], **body)


def soccer(**body: float) -> Coupling:
    """Front wheels at 33, rear ones at 45 degrees; front is +y, as in the published example."""
    return omni_coupling(np.deg2rad([33.0, 147.0, 225.0, 315.0]), **body)


def scattered(rng: np.random.Generator, n: int) -> Coupling:
    """n wheels anywhere on a ring, each sector has one, driving a little past its centre."""
    phi = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    return omni_coupling(phi, radius=0.1, alpha=rng.uniform(0.3, 1.2), levers=0.1 * rng.uniform(0.7, 1.3, n))


def drive(rng: np.random.Generator, samples: int) -> np.ndarray:
    """Twists (N, 3) of a drive at 1 kHz that keeps within 4 m/s2 and 20 rad/s2."""
    t = 1e-3 * np.arange(samples)[:, None]
    rate, phase = rng.uniform(1.0, 3.0, 3), rng.uniform(0.0, 6.28, 3)
    return np.array([1.0, 1.0, 4.0]) * np.sin(rate * t + phase)


def log(rng: np.random.Generator, base: Coupling, samples: int, slips: dict[int, np.ndarray]) -> tuple[np.ndarray, ...]:
    """True twists, noisy rim speeds with slip added, noisy gyro."""
    twist = drive(rng, samples)
    m = rim_speeds(base, twist) + NOISE * rng.standard_normal((samples, base.wheels))
    for wheel, slip in slips.items():
        m[:, wheel] += slip
    return twist, m, twist[:, 2] + RATE_NOISE * rng.standard_normal(samples)


def burst(samples: int, begin: int, end: int, size: float, rise: int = 1) -> np.ndarray:
    """Slip (N,) from begin to end that grows to its size within `rise` samples."""
    k = np.arange(samples)
    return np.where((k >= begin) & (k < end), size * np.clip((k - begin + 1) / rise, 0.0, 1.0), 0.0)
