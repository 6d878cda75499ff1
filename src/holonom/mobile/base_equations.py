"""The models of a base as equations over samples, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from holonom.errors import UnknownName
from holonom.mobile.equations import base_models as models
from holonom.mobile.equations.base_models import Layout
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
    def equation(twist: Row) -> tuple[Any, list[Any]]:
        speeds, drag = models.free_wheel_speeds(layout, list(twist))
        return speeds, [drag]

    return BaseEquation(equation, {"twist": 3}, {"speeds": m, "drag": 1}, "free_wheel_speeds")


def _steering(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)
    return BaseEquation(
        lambda twist: (models.steering_angles(layout, list(twist), None),), {"twist": 3}, {"steering": k}, "steering"
    )


def _steering_near(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)
    return BaseEquation(
        lambda twist, current: (models.steering_angles(layout, list(twist), current),),
        {"twist": 3, "current": k}, {"steering": k}, "steering_near",
    )  # fmt: skip


def _twist(layout: Layout, m: int) -> BaseEquation:
    k = len(layout.groups)

    def equation(speeds: Row, steering: Row) -> tuple[Any, list[Any]]:
        axles = models.axles_at(layout, steering if k else ())
        twist, determined = models.twist_of_speeds(layout, list(speeds), axles)
        return twist, [determined]

    return BaseEquation(equation, {"speeds": m, "steering": max(k, 1)}, {"twist": 3, "determined": 1}, "base_twist")


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
