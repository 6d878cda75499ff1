"""The hand: what two fingers can grasp, how parts fall, and what is a collision."""

from __future__ import annotations

import numpy as np
import pytest
from demo_cell import make_disc, make_hand, tool_down

from holonom.errors import MotionError
from holonom.sim import Disc, Fingers
from holonom.spatial import pose

AT = (0.5, -0.1)
GRASP = 0.301
"""Height of the fingertips when they grasp a coin on the table, m."""


def close(hand: Fingers, T: np.ndarray, ticks: int = 20) -> list[str]:
    hand.send(0.0)
    return [what for _ in range(ticks) for what in hand.step(T, 0.01)]


def release(hand: Fingers, T: np.ndarray, ticks: int = 60) -> list[str]:
    hand.send(hand.gripper.max_opening)
    return [what for _ in range(ticks) for what in hand.step(T, 0.01)]


def test_a_coin_between_the_fingers_is_grasped() -> None:
    disc = make_disc(*AT)
    hand = make_hand([disc])
    assert hand.idle
    np.testing.assert_array_equal(hand.payload, np.zeros(4))
    assert close(hand, tool_down(*AT, GRASP)) == ["grasped coin_01"]
    assert hand.held is disc
    assert hand.idle
    assert hand.opening == pytest.approx(2 * disc.radius)
    np.testing.assert_allclose(hand.payload, [disc.mass, 0.0, 0.0, GRASP - disc.pose[2, 3]], atol=1e-12)


def test_the_fingers_push_a_coin_to_their_middle() -> None:
    disc = make_disc(AT[0] + 0.002, AT[1] + 0.004)
    hand = make_hand([disc])
    hand.send(0.0)
    for _ in range(3):
        hand.step(tool_down(*AT, GRASP), 0.01)
    assert hand.opening == pytest.approx(0.0245)
    assert disc.pose[1, 3] == pytest.approx(AT[1] + hand.opening / 2 - disc.radius), "a finger pushes its edge"
    assert close(hand, tool_down(*AT, GRASP)) == ["grasped coin_01"]
    np.testing.assert_allclose(disc.pose[:3, 3], [AT[0] + 0.002, AT[1], 0.30125], atol=1e-12)


@pytest.mark.parametrize(
    ("x", "y", "z"),
    [
        (0.0, 0.0, 0.304),  # fingertips above it
        (0.0, 0.0, 0.3024),  # fingertips overlap its edge by 0.1 mm only
        (0.015, 0.0, GRASP),  # beside the fingers
        (0.0, 0.05, GRASP),  # outside them
    ],
)
def test_what_is_not_between_the_fingers_stays(x: float, y: float, z: float) -> None:
    disc = make_disc(*AT)
    hand = make_hand([disc])
    assert close(hand, tool_down(AT[0] + x, AT[1] + y, z)) == []
    assert hand.held is None
    assert hand.opening == 0.0
    assert disc.pose[2, 3] == pytest.approx(0.30125)
    assert hand.payload[0] == 0.0


def test_a_tilted_hand_does_not_grasp() -> None:
    """Hand and coin have to be level: turned by 45 degrees the fingers close into the coin."""
    c = np.sqrt(0.5)
    tilted = np.array([[c, 0.0, -c], [0.0, -1.0, 0.0], [-c, 0.0, -c]])
    disc = make_disc(*AT)
    hand = make_hand([disc])
    with pytest.raises(MotionError, match="a finger hit"):
        close(hand, pose((*AT, GRASP), tilted))
    assert hand.held is None


def test_a_coin_moves_with_the_hand_and_falls_to_what_is_below() -> None:
    disc = make_disc(*AT)
    hand = make_hand([disc])
    close(hand, tool_down(*AT, GRASP))
    for y in np.linspace(AT[1], 0.2, 50):
        hand.step(tool_down(0.7, y, 0.4), 0.01)
    np.testing.assert_allclose(disc.pose[:3, 3], [0.7, 0.2, 0.4 + 0.30125 - GRASP], atol=1e-12)
    happened = release(hand, tool_down(0.7, 0.2, 0.4))
    assert happened == ["released coin_01", "coin_01 lies at 700.0, 200.0, 303.2 mm"]
    assert disc.pose[2, 3] == pytest.approx(0.302 + disc.thickness / 2)
    assert hand.held is None
    assert hand.payload[0] == 0.0


def test_fingers_that_close_off_centre_hit_the_coin() -> None:
    hand = make_hand([make_disc(*AT)])
    with pytest.raises(MotionError, match="a finger hit coin_01"):
        close(hand, tool_down(AT[0] + 0.005, AT[1], GRASP))


@pytest.mark.parametrize(("x", "y", "floor"), [(0.5, 0.1, 0.3), (0.7, 0.2, 0.302), (0.2, 0.0, 0.0)])
def test_it_lands_on_table_tray_or_floor_after_the_time_of_a_free_fall(x: float, y: float, floor: float) -> None:
    disc = make_disc(*AT)
    hand = make_hand([disc])
    close(hand, tool_down(*AT, GRASP))
    hand.step(tool_down(x, y, 0.5), 0.01)
    height = disc.pose[2, 3] - floor - disc.thickness / 2
    hand.send(1.0)
    hand.step(tool_down(x, y, 0.5), 0.01)
    ticks = 0
    while disc.state != "resting":
        hand.step(tool_down(x, y, 0.5), 0.01)
        ticks += 1
        assert ticks < 100
    assert disc.pose[2, 3] == pytest.approx(floor + disc.thickness / 2)
    assert 0.01 * ticks == pytest.approx(np.sqrt(2 * height / 9.81), abs=0.025)


def test_it_lands_on_another_coin() -> None:
    disc, other = make_disc(*AT), make_disc(0.5, 0.1, "coin_02", thickness=0.004)
    hand = make_hand([disc, other])
    close(hand, tool_down(*AT, GRASP))
    hand.step(tool_down(0.5, 0.11, 0.35), 0.01)
    release(hand, tool_down(0.5, 0.11, 0.35))
    assert disc.pose[2, 3] == pytest.approx(0.304 + disc.thickness / 2)


@pytest.mark.parametrize("opening", [0.035, 0.01])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_finger_in_a_coin_is_a_collision(opening: float, side: float) -> None:
    hand = make_hand([make_disc(*AT)])
    release(hand, tool_down(0.5, 0.2, 0.4), 1)
    hand.send(opening)
    for _ in range(20):
        hand.step(tool_down(*AT, 0.4), 0.01)
    finger = (opening + hand.gripper.finger_thickness) / 2
    T = tool_down(AT[0], AT[1] + side * finger, 0.301)
    with pytest.raises(MotionError, match=r"a finger hit coin_01 \(\d+\.\d mm inside its edge\)"):
        hand.step(T, 0.01)
    hand.step(tool_down(AT[0], AT[1] + side * finger, 0.3025), 0.01)


def test_open_fingers_clear_a_coin_by_what_is_left() -> None:
    """17.5 mm to either side: a coin of 17.4 mm radius fits between, one of 18.1 mm does not."""
    for radius, hits in ((0.0174, False), (0.0181, True)):
        disc: Disc = make_disc(*AT, radius=radius)
        hand = make_hand([disc])
        if hits:
            with pytest.raises(MotionError, match="a finger hit"):
                hand.step(tool_down(*AT, GRASP), 0.01)
        else:
            assert hand.step(tool_down(*AT, GRASP), 0.01) == []


def test_the_hand_takes_its_time() -> None:
    hand = make_hand()
    ticks = 0
    hand.send(0.0)
    while not hand.idle:
        hand.step(tool_down(*AT, 0.4), 0.01)
        ticks += 1
    assert 0.01 * ticks == pytest.approx(hand.gripper.max_opening / hand.gripper.speed, abs=0.011)
    hand.send(1.0)
    for _ in range(20):
        hand.step(tool_down(*AT, 0.4), 0.01)
    assert hand.opening == hand.gripper.max_opening
