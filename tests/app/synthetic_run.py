"""A run that never happened, but is geometrically right: a Puma 560 carries coins from a table to a tray.

Standard Denavit-Hartenberg frames, inverse kinematics by least squares, smooth joint interpolation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from holonom.app.recording import Recorder
from holonom.app.report import (
    Box,
    Detection,
    Disc,
    Label,
    LimitUse,
    PhotoOverlay,
    Scene,
    View,
    arm_shapes,
    gripper_shapes,
)
from holonom.signals import DriveState, Event, FramePoses, JointCommand, JointState

JOINTS = ("waist", "shoulder", "elbow", "wrist roll", "wrist bend", "flange")
A = np.array([0, 0.4318, 0.0203, 0, 0, 0])
D = np.array([0.67183, 0, 0.15005, 0.4318, 0, 0])
ALPHA = np.radians([90, 0, -90, 90, -90, 0])
LENGTH, TABLE, COIN = 0.12, 0.30, 0.003
COLOURS = {"small": "#1f8a70", "medium": "#e08e0b", "large": "#c2385a"}
PIXEL = 0.0005


def frames(q: np.ndarray) -> np.ndarray:
    """T_w1 to T_w6 and the tool, (7, 4, 4)."""
    T, out = np.eye(4), []
    for a, d, alpha, angle in zip(A, D, ALPHA, q, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        step = [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
        T = T @ np.array(step)
        out.append(T)
    tool = np.eye(4)
    tool[2, 3] = LENGTH
    return np.array([*out, T @ tool])


def solve(point: np.ndarray, q0: np.ndarray) -> np.ndarray:
    """Joints with the tool at `point`, pointing down, fingers along world y."""
    down = np.diag([1.0, -1.0, -1.0])

    def miss(q: np.ndarray) -> np.ndarray:
        T = frames(q)[-1]
        return np.concatenate([5 * (T[:3, 3] - point), (T[:3, :3] - down).ravel()])

    q = least_squares(miss, q0, method="lm", xtol=1e-12).x
    return q0 + (q - q0 + np.pi) % (2 * np.pi) - np.pi


@dataclass
class Coin:
    """Where a coin lies, where it goes, its radius and group, its pixel on the photograph."""

    start: np.ndarray
    goal: np.ndarray
    radius: float
    group: str
    pixel: np.ndarray


def coins_from(pixels: np.ndarray) -> list[Coin]:
    """Coins from rows (u, v, diameter in px)."""
    out, used = [], {"small": 0, "medium": 0, "large": 0}
    corner = {"small": (0.41, 0.06, 6), "medium": (0.41, 0.20, 2), "large": (0.53, 0.20, 2)}
    for u, v, diameter in pixels:
        group = "small" if diameter < 48.7 else "medium" if diameter < 52.8 else "large"
        x, y, columns = corner[group]
        row, column = divmod(used[group], columns)
        used[group] += 1
        goal = np.array([x + 0.038 * column, y + 0.038 * row, TABLE + 0.006 + COIN / 2])
        start = np.array([0.40 + PIXEL * u, -0.05 - PIXEL * v, TABLE + COIN / 2])
        out.append(Coin(start, goal, diameter * PIXEL / 2, group, np.array([u, v])))
    return out


def record(path, coins: list[Coin], *, dt: float = 0.01, leg: float = 0.35) -> float:
    """Write the recording of all coins moved; returns its end, s."""
    q = solve(np.array([0.5, -0.1, 0.5]), np.radians([5.8, 49.4, -198.2, 0, -31.2, -174.2]))
    names = (*(f"link{i}" for i in range(1, 7)), "tool", "finger_left", "finger_right")
    names += tuple(f"coin_{i:02d}" for i in range(1, len(coins) + 1))
    poses = np.tile(np.eye(4), (len(names), 1, 1))
    poses[9:, :3, 3] = [coin.start for coin in coins]
    rng = np.random.default_rng(3)
    t, opening, line = 0.0, 0.04, 1
    with Recorder(path, JOINTS) as out:
        for i, coin in enumerate(coins):
            grip = 2 * coin.radius
            lift = np.array([0, 0, 0.08])
            legs = [(coin.start + lift, 0.046), (coin.start, 0.046), (coin.start, grip), (coin.start + lift, grip)]
            legs += [(coin.goal + lift, grip), (coin.goal, grip), (coin.goal, 0.046), (coin.goal + lift, 0.046)]
            texts = ["approach", "down", "close", "lift", "carry", "put down", "open", "depart"]
            for k, ((point, wanted), text) in enumerate(zip(legs, texts, strict=True)):
                line = 8 + k
                out.put(Event(t, "info", "sort_coins.arps", f"coin {i + 1}: {text}", line))
                q1 = solve(point, q)
                for s in np.arange(0, 1, dt / leg):
                    blend, slope = s**3 * (10 - 15 * s + 6 * s * s), 30 * s * s * (1 - s) ** 2 / leg
                    want, speed = q + blend * (q1 - q), slope * (q1 - q)
                    gap = opening + blend * (wanted - opening)
                    have = want - 0.002 * speed + rng.normal(0, 2e-5, 6)
                    place(poses, have, gap)
                    if 2 <= k <= 5:
                        poses[9 + i, :3, 3] = poses[6, :3, 3]
                    out.put(JointState(t, have, speed, 20 * speed))
                    out.put(JointCommand(t, want, speed, 0 * speed))
                    out.put(DriveState(t, 1.5 * speed + rng.normal(0, 0.05, 6), 14 * speed))
                    out.put(FramePoses(t, names, poses))
                    t += dt
                q, opening = q1, wanted
    return t


def place(poses: np.ndarray, q: np.ndarray, gap: float) -> None:
    """Fill links, tool and fingers."""
    poses[:7] = frames(q)
    for row, side in ((7, 0.5), (8, -0.5)):
        finger = np.eye(4)
        finger[1, 3] = side * gap
        poses[row] = poses[6] @ finger


def at(x: float, y: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def scene(coins: list[Coin], *, photo: bool) -> Scene:
    """Table, tray with three fields, gripper, arm and coins."""
    shapes = [*arm_shapes("puma560"), *gripper_shapes(length=LENGTH)]
    shapes.append(Box("world", at(0.52, 0.02, TABLE - 0.0155), (0.42, 0.66, 0.03), "#d8c3a5"))
    shapes += [Box("world", at(x, y, TABLE / 2 - 0.02), (0.03, 0.03, TABLE - 0.04), "#8d99ae")
               for x in (0.34, 0.70) for y in (-0.28, 0.32)]  # fmt: skip
    fields = {"small": (0.505, 0.098, 0.234, 0.118), "medium": (0.43, 0.202, 0.08, 0.042)}
    fields["large"] = (0.55, 0.221, 0.08, 0.08)
    for name, (x, y, width, depth) in fields.items():
        shapes.append(Box("world", at(x, y, TABLE + 0.003), (width, depth, 0.006), COLOURS[name]))
        pose = at(x, y + depth / 2 + 0.014, TABLE + 0.002)
        pose[:2, :2] = [[-1, 0], [0, -1]]
        shapes.append(Label("world", pose, name, 0.016))
    for i, coin in enumerate(coins, start=1):
        axes = np.array([[1 / PIXEL, 0], [0, -1 / PIXEL]])
        pixel = (coin.pixel, axes) if photo else (None, None)
        shapes.append(Disc(f"coin_{i:02d}", coin.radius, COIN, "#b08d57", *pixel))
    views = (
        View("Overview", (1.45, -0.95, 1.1), (0.27, 0.0, 0.43)),
        View("Table", (0.95, -0.4, 0.75), (0.5, 0.0, 0.3)),
    )
    return Scene(tuple(shapes), views)


def overlay(coins: list[Coin], png: bytes, width: int, height: int) -> PhotoOverlay:
    found = tuple(
        Detection(
            u=c.pixel[0],
            v=c.pixel[1],
            diameter=2 * c.radius / PIXEL,
            group=c.group,
            x=c.pixel[0] * PIXEL,
            y=-c.pixel[1] * PIXEL,
            size=2 * c.radius,
            frame=f"coin_{i:02d}",
        )
        for i, c in enumerate(coins, start=1)
    )
    return PhotoOverlay(png, width, height, found, COLOURS, "Greek coins from Pompeii, Brooklyn Museum.")


def limits() -> tuple[LimitUse, ...]:
    peak, limit = np.array([1.2, 1.1, 2.0, 1.1, 0.5, 4.0]), np.array([2.0, 1.2, 2.1, 4.3, 4.6, 5.0])
    return (
        LimitUse("Joint speed", "rad/s", peak, limit),
        LimitUse("Motor voltage", "V", 10 * peak, np.full(6, 40.0)),
        LimitUse("Motor current", "A", peak, limit * 0.98),
    )
