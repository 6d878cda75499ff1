"""The models of a base as equations over samples, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from holonom.errors import UnknownName
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.equations import base_models as models
from holonom.mobile.equations.base_models import Layout
from holonom.mobile.equations.forward import always_determined, twist_of_speeds
from holonom.mobile.equations.steering import free_wheel_speeds, steering_angles
from holonom.mobile.evaluation import BaseEquation

__all__ = ["EQUATIONS", "make"]

Row = Sequence[Any]


def _wheel_speeds(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)

    def equation(twist: Row, steering: Row) -> tuple[Any, list[Any]]:
        axles = models.axles_at(layout, steering if k else ())
        return models.wheel_speeds(layout, list(twist), axles), [models.drag(layout, list(twist), axles)]

    return BaseEquation(equation, {"twist": 3, "steering": max(k, 1)}, {"speeds": m, "drag": 1}, "wheel_speeds")


def _free_wheel_speeds(layout: Layout, m: int) -> BaseEquation:
    """Without a drag where all wheels that might drag steer alone."""
    alone = {layout.wheels[g[0]].name for g in layout.groups if len(g) == 1}
    held = any(w.name not in alone and KINDS[w.kind].sliding(w, 0.0, 1.0) for w in layout.wheels)

    def equation(twist: Row) -> tuple[Any, ...]:
        speeds, drag = free_wheel_speeds(layout, list(twist))
        return (speeds, [drag]) if held else (speeds,)

    return BaseEquation(equation, {"twist": 3}, {"speeds": m, **({"drag": 1} if held else {})}, "free_wheel_speeds")


def _steering(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)
    return BaseEquation(
        lambda twist: (steering_angles(layout, list(twist), None),), {"twist": 3}, {"steering": k}, "steering"
    )


def _steering_near(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)
    return BaseEquation(
        lambda twist, current: (steering_angles(layout, list(twist), current),),
        {"twist": 3, "current": k}, {"steering": k}, "steering_near",
    )  # fmt: skip


def _twist(layout: Layout, m: int) -> BaseEquation:
    """Without a measure of it where the twist is determined at any steering."""
    k, always = len(layout.groups), always_determined(layout)

    def equation(speeds: Row, steering: Row) -> tuple[Any, ...]:
        axles = models.axles_at(layout, steering if k else ())
        twist, determined = twist_of_speeds(layout, list(speeds), axles)
        return (twist,) if always else (twist, [determined])

    outputs = {"twist": 3, **({} if always else {"determined": 1})}
    return BaseEquation(equation, {"speeds": m, "steering": max(k, 1)}, outputs, "base_twist")


def _rolling(layout: Layout, m: int) -> BaseEquation:
    return _rows(layout, lambda axles: models.rolling_rows(layout, axles, driven=False), "rolling_rows")


def _sliding(layout: Layout, m: int) -> BaseEquation:
    return _rows(layout, lambda axles: models.sliding_rows(layout, axles), "sliding_rows")


def _rows(layout: Layout, rows: Callable[[Any], list[Any]], name: str) -> BaseEquation:
    k = len(layout.groups)
    width = 3 * len(rows(models.axles_at(layout, [0.0] * k)))

    def equation(steering: Row) -> tuple[list[Any]]:
        return ([x for _, row in rows(models.axles_at(layout, steering if k else ())) for x in row],)

    return BaseEquation(equation, {"steering": max(k, 1)}, {name: width}, name)


EQUATIONS: Mapping[str, Callable[[Layout, int], BaseEquation]] = {
    "wheel_speeds": _wheel_speeds,
    "free_wheel_speeds": _free_wheel_speeds,
    "steering": _steering,
    "steering_near": _steering_near,
    "twist": _twist,
    "rolling_rows": _rolling,
    "sliding_rows": _sliding,
}
"""Name -> equation of a base. Bases without steering have one unused steering angle among the inputs."""


def make(name: str, layout: Layout, m: int) -> BaseEquation:
    """Return an equation by its name.

    Raises
    ------
    UnknownName
    """
    if name not in EQUATIONS:
        raise UnknownName("equation of a base", name, EQUATIONS)
    return EQUATIONS[name](layout, m)
