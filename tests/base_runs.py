"""Logs of any wheel set whose true numbers are known: wheels by the inverse model of a true base, with noise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import holonom as hm
from holonom.mobile import WheelBase
from holonom.mobile.calibration import Run
from holonom.mobile.odometry import integrate

m = hm.mobile
BASES: dict[str, WheelBase] = {
    "differential": m.differential(0.3, 0.05),
    "tricycle": m.tricycle(0.4, 0.3, 0.05),
    "bicycle": m.bicycle(0.4, 0.05),
    "ackermann": m.ackermann(0.4, 0.3, 0.05),
    "dual_ackermann": m.dual_ackermann(0.4, 0.3, 0.05),
    "synchro": m.synchro(0.2, 0.05),
    "omni": m.omni([0.1, 1.3, 2.6, 3.8, 5.1], radius=0.2, wheel_radius=0.05),
    "mecanum": m.mecanum(0.4, 0.3, 0.05),
    "swerve": m.swerve(wheelbase=0.4, track=0.3, wheel_radius=0.05),
    "skid_steer": m.skid_steer(0.4, 0.3, 0.05),
    "segway": m.segway(0.4, 0.1),
    "rocker6": m.rocker6(0.8, 0.6, 0.1),
    "sphere": m.sphere(0.1),
}
DT = 0.05


def _word(name: str) -> str:
    return name.replace(" ", "_")


def true_base(base: WheelBase, truth: Mapping[str, float]) -> WheelBase:
    """The base with other numbers: written here from what each name means, not from the product's derivation."""
    wheels = []
    acting = np.array([w.acts_at or (w.x, w.y) for w in base.wheels])
    kinds = [w.kind for w in base.wheels]
    fixed = np.array([k == "fixed" for k in kinds])
    for w in base.wheels:
        x, y = w.x, w.y
        radius = truth.get(f"radius_{_word(w.name)}", w.radius)
        if w.kind == "fixed" and "track" in truth:
            y = np.sign(y) * 0.5 * truth["track"]
        if w.kind in ("swedish", "steered") and "lever" in truth:
            centre = acting[[k == w.kind for k in kinds]].mean(axis=0)
            size = np.hypot(*(acting[[k == w.kind for k in kinds]] - centre).T).mean()
            x, y = centre + (np.array([x, y]) - centre) * truth["lever"] / size
        if w.kind == "steered" and "wheelbase" in truth:
            behind = acting[fixed, 0].mean()
            away = np.abs(acting[[k == "steered" for k in kinds], 0] - behind).mean()
            x = behind + (x - behind) * truth["wheelbase"] / away
        made = m.Wheel.at(
            w.kind, x, y, w.heading, radius=radius, roller_angle=w.roller_angle, castor_offset=w.castor_offset,
            driven=w.driven, name=w.name,
            acts_at=(truth["centre"], np.sign(w.acts_at[1]) * 0.5 * truth["effective_track"]) if w.acts_at else None,
        )  # fmt: skip
        wheels.append(made)
    groups = {
        name: [base.wheels[i].name for i in members]
        for name, members in zip(base.steered, base.layout.groups, strict=True)
        if len(members) > 1
    }
    return WheelBase(wheels, name=base.name, radius=base.radius, steering_groups=groups)


def log_of(
    base: WheelBase, truth: Mapping[str, float], rng: np.random.Generator, *, samples: int = 240, slip: float = 0.0,
    place: float = 0.0, heading: float = 0.0, ticks: int = 0, name: str = "run",
) -> Run:  # fmt: skip
    """A wandering run; `slip` is a random walk of the base per root of the way, `place`, `heading` are the truth's."""
    real = true_base(base, truth)
    time = DT * np.arange(samples)
    wave = sum(
        np.sin(rng.uniform(0.3, 1.6, 3) * time[:, None] + rng.uniform(0.0, 6.0, 3)) * rng.normal(size=3)
        for _ in range(3)
    )
    twists = wave * [0.4, 0.3, 1.0]
    if any(w.kind == "fixed" for w in base.wheels) and base.steered:
        twists[:, 0] = 0.4 + 0.1 * np.tanh(wave[:, 0])  # steered wheels on one side of their rest
        twists[:, 2] = 1.2 * np.tanh(twists[:, 2])
    if "ackermann" in base.name and not any(w.kind == "fixed" for w in base.wheels):
        twists[:, 0] = 0.5 + 0.1 * np.tanh(wave[:, 0])
        twists[:, 1] = 0.1 * np.tanh(wave[:, 1])
        twists[:, 2] = 0.4 * np.tanh(wave[:, 2])
    twists = real.feasible(twists)
    steering = real.steering(twists, np.zeros((samples, len(base.steered)))) if base.steered else np.empty((samples, 0))
    turns = (
        DT * real.wheel_speeds(twists, steering, tolerance=1e-6)
        if base.steered
        else DT * real.wheel_speeds(twists, tolerance=np.inf)
    )
    turns[0] = 0.0
    way = np.abs(turns).mean(axis=1)[:, None]
    moved = DT * twists + slip * np.sqrt(way) * rng.normal(size=(samples, 3))
    moved[0] = 0.0
    poses = integrate(moved, rule="exact")
    poses = poses + rng.normal(size=(samples, 3)) * [place, place, heading]
    if ticks:
        unit = 2.0 * np.pi / ticks
        turns = np.diff(np.round(np.cumsum(turns, axis=0) / unit), axis=0, prepend=0.0) * unit
    noise = 0.003 * rng.normal(size=steering.shape) if ticks else 0.0
    zero = np.array([truth.get(f"zero_{_word(g)}", 0.0) for g in base.steered])
    return Run(name, time, turns, poses, (steering - zero) / truth.get("steering_gear", 1.0) + noise)
