"""Draws the figures of the documentation into `docs/pictures`: `python tools/make_figures.py [NAME ...]`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

import holonom as hm
from holonom import plots
from holonom.mechanics import Arm, IkStatus, motion
from holonom.mechanics.simulate import ComputedTorque, simulate_ensemble
from holonom.mobile import arrangements, stability
from holonom.plots.arm import draw_sticks, room
from holonom.plots.base import draw_base_on
from holonom.plots.skeleton import reach, sticks

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
DPI = 110
PUMA_START = np.array([0.0, 0.6, -2.8, 0.0, 0.6, 0.0])


def small_arm(axes: Any, arm: Arm, q: np.ndarray, view: tuple[float, float], *, alpha: float = 1.0) -> None:
    """An arm without scales, for figures of many."""
    lines = sticks(arm, arm.frames(q))
    draw_sticks(axes, lines, alpha=alpha)
    room(axes, *reach(lines), view)
    axes.set(xticks=[], yticks=[], zticks=[], xlabel="", ylabel="", zlabel="")
    axes.set_box_aspect((1, 1, 1), zoom=1.1)


def presets() -> Figure:
    """Every preset in a typical configuration."""
    figure = Figure(figsize=(9.6, 5.2), layout="constrained")
    poses = {"puma560": "nominal", "pendulum": "zero"}
    for k, name in enumerate(hm.model.preset_names()):
        arm = hm.load_arm(name)
        axes = figure.add_subplot(2, 4, k + 1, projection="3d")
        q = np.array(arm.model.poses[poses.get(name, "ready")])
        small_arm(axes, arm, q + (0.4 if name == "pendulum" else 0.0), (20, -60))
        axes.set_title(name, fontsize=10)
    return figure


def branches() -> Figure:
    """The eight branches of the Puma for one pose; those out of limits pale."""
    arm = hm.load_arm("puma560")
    found = arm.ik(arm.fk([0.3, 0.8, -2.6, 0.4, 0.9, -0.5]))
    figure = Figure(figsize=(9.6, 5.4), layout="constrained")
    for k, (name, q, status) in enumerate(zip(found.names, found.q, found.status, strict=True)):
        axes = figure.add_subplot(2, 4, k + 1, projection="3d")
        fits = status == IkStatus.OK
        small_arm(axes, arm, q, (18, -50), alpha=1.0 if fits else 0.3)
        axes.set_title(f"{name}\n{IkStatus(status).name}", fontsize=9, color="black" if fits else "0.5")
    return figure


def workspace() -> Figure:
    """A slice of what the Puma reaches."""
    return plots.draw_workspace(hm.load_arm("puma560"), thickness=0.1, samples=10_000_000, cells=70)


def manipulability() -> Figure:
    """Manipulability of the Puma over shoulder and elbow, with two of the named singularities."""
    arm = hm.load_arm("puma560")
    figure = plots.draw_manipulability(arm, [0.0, 0.8, -2.6, 0.0, 0.9, 0.0])
    q2, q3 = np.meshgrid(*(np.linspace(arm.limits.lower[k], arm.limits.upper[k], 200) for k in (1, 2)))
    s, c = np.sin, np.cos
    shoulder = 0.4318 * c(q2) + 0.0203 * c(q2 + q3) - 0.4318 * s(q2 + q3)
    elbow = 0.0203 * s(q3) + 0.4318 * c(q3)
    axes = figure.axes[0]
    for values, style in ((shoulder, "-"), (elbow, "--")):
        axes.contour(q2, q3, values, [0.0], colors="white", linewidths=1.8, linestyles=style)
    axes.plot([], [], "w-", label="shoulder singularity")
    axes.plot([], [], "w--", label="elbow singularity")
    axes.legend(loc="lower left", facecolor="#46527a", labelcolor="white")
    return figure


def ellipsoids() -> Figure:
    """Velocity and force ellipsoid of the Puma, nearly stretched."""
    return plots.draw_ellipsoids(hm.load_arm("puma560"), [0.3, 0.5, -1.9, 0.4, 0.9, -0.5])


def profiles() -> Figure:
    """A synchronised motion from point to point."""
    arm = hm.load_arm("puma560")
    goal = PUMA_START + np.array([0.5, 0.1, 0.2, 0.0, 0.3, 1.0])
    there = motion.plan_joint(PUMA_START, goal, arm.limits, speed=0.8)
    return plots.draw_profiles(there, arm.limits, names=arm.limits.names)


def retimed() -> Figure:
    """What each joint uses of its limits on a time-optimal motion with weak motors."""
    arm = hm.load_arm("puma560")
    via = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.3, 0.2, 0.0, 0.3, 1.0], [1.0, -0.1, 0.2, 0.3, 0.3, 1.5]])
    torque = 0.4 * arm.limits.torque
    quick = motion.retime(motion.joint_spline(PUMA_START + via), arm.limits, arm=arm, torque=torque)
    tau = arm.inverse_dynamics(quick.q, quick.qd, quick.qdd)
    figure = plots.draw_profiles(quick, arm.limits, names=arm.limits.names)
    axes = figure.axes[0]  # torques in place of positions
    for line, values in zip(axes.lines, (tau / torque).T, strict=True):
        line.set_ydata(values)
    axes.set(ylabel="torque / limit", ylim=(-1.15, 1.15))
    for bound in (-1.0, 1.0):
        axes.axhline(bound, color="0.3", linestyle="--", linewidth=0.9)
    return figure


def ensemble() -> Figure:
    """Pumas with loads that their controller does not know of."""
    arm = hm.load_arm("puma560")
    q = np.array(arm.model.poses["nominal"])
    loads = np.linspace(0.0, 2.0, 41)
    law = ComputedTorque(kp=100.0, kd=20.0)
    found = simulate_ensemble(arm, law, q, np.zeros(6), 1.0, payload=loads, every=10, friction=False)
    shades = Normalize(0.0, 2.0)
    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    both = figure.subplots(1, 2, sharex=True)
    for axes, j in zip(both, (1, 2), strict=True):
        for load, motion_ in zip(loads, found.q, strict=True):
            axes.plot(found.t, 1e3 * (motion_[:, j] - q[j]), color=colormaps["viridis"](shades(load)), lw=0.9)
        axes.set(xlabel="time (s)", ylabel=f"error of the {arm.limits.names[j]} (mrad)", xlim=(0.0, 1.0))
    figure.colorbar(ScalarMappable(shades, "viridis"), ax=both, label="load (kg)")
    return figure


def bases() -> Figure:
    """Every arrangement of wheels on the way, with its centre of rotation."""
    figure = Figure(figsize=(11.0, 8.4), layout="constrained")
    moving = {
        "differential": (arrangements.differential(0.3, 0.06), (0.4, 0.0, 1.4)),
        "tricycle": (arrangements.tricycle(1.2, 0.8, 0.16), (0.4, 0.0, 0.35)),
        "ackermann": (arrangements.ackermann(2.5, 1.5, 0.32), (1.0, 0.0, 0.25)),
        "bicycle": (arrangements.bicycle(1.1, 0.3), (0.8, 0.0, 0.4)),
        "dual_ackermann": (arrangements.dual_ackermann(0.5, 0.4, 0.07), (0.4, 0.0, 0.5)),
        "skid_steer": (arrangements.skid_steer(0.3, 0.4, 0.07), (0.3, 0.0, 0.6)),
        "rocker6": (arrangements.rocker6(0.8, 0.6, 0.09), (0.3, 0.0, 0.3)),
        "segway": (arrangements.segway(0.4, 0.1), (0.3, 0.0, 1.0)),
        "synchro": (arrangements.synchro(0.25, 0.07), (0.3, 0.2, 0.0)),
        "omni": (arrangements.omni(n=3, radius=0.2, wheel_radius=0.06), (0.3, 0.0, 1.0)),
        "mecanum": (arrangements.mecanum(0.4, 0.3, 0.08), (0.3, 0.3, 0.0)),
        "swerve": (arrangements.swerve(wheelbase=0.5, track=0.4, wheel_radius=0.07), (0.3, 0.2, 0.9)),
        "sphere": (arrangements.sphere(0.11), (0.3, 0.1, 0.0)),
    }
    for k, (name, (base, twist)) in enumerate(moving.items()):
        axes = figure.add_subplot(3, 5, k + 1)
        draw_base_on(axes, base, twist, names=False)
        axes.set_title(name, fontsize=10)
        axes.set(xticks=[], yticks=[], xlabel="", ylabel="")
    entries: dict[str, Any] = {}
    for axes in figure.axes:
        entries |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=5, fontsize=9, frameon=False)
    return figure


def tipping() -> Figure:
    """How hard a car and a tricycle may accelerate in every direction before a wheel lifts."""
    figure = Figure(figsize=(8.4, 4.2), layout="constrained")
    body = {"com": (0.5, 0.0), "com_height": 0.5}
    tricycle = arrangements.tricycle(1.2, 0.8, 0.16, **body)
    car = arrangements.ackermann(1.2, 0.8, 0.16, **body)
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    left = figure.add_subplot(1, 2, 1)
    draw_base_on(left, tricycle)
    left.set_title("the tricycle", fontsize=10)
    polar: Any = figure.add_subplot(1, 2, 2, projection="polar")
    polar.set_theta_zero_location("N")
    for base, color in ((tricycle, "#D55E00"), (car, "#0072B2")):
        limit = stability.acceleration_limit(base, angle)
        polar.plot(angle, limit, color=color, label="tricycle" if base is tricycle else "four wheels")
    polar.set_title("largest acceleration (m/s²) by direction", fontsize=10)
    polar.set_rlabel_position(68)
    polar.legend(loc="lower left", bbox_to_anchor=(-0.18, -0.1), fontsize=8)
    return figure


FIGURES: dict[str, Callable[[], Figure]] = {
    f.__name__: f
    for f in (presets, branches, workspace, manipulability, ellipsoids, profiles, retimed, ensemble, bases, tipping)
}


def main() -> None:
    """Draw all figures, or those named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(FIGURES)}; all by default")
    for name in parser.parse_args().names or FIGURES:
        picture = PICTURES / f"{name}.png"
        FIGURES[name]().savefig(picture, dpi=DPI, metadata={"Software": None})
        print(picture)


if __name__ == "__main__":
    main()
