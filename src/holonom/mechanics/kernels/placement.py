"""What of an arm may be inputs of a kernel instead of numbers in it: base, tool, gravity, payload.

The equations read them from the model as they read any constant. Where they are asked for as inputs, the model that an
equation sees holds traced scalars in their place: one kernel then serves every base, tool and load.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from holonom.errors import MissingInertia, UnknownName
from holonom.mechanics.equations.dynamics.inertia import Inertial, merged
from holonom.mechanics.equations.dynamics.rotors import links_with_rotors
from holonom.mechanics.equations.vectors import Vector
from holonom.model import ArmModel
from holonom.trace import Kernel, compile

__all__ = ["GIVEN", "NEEDED", "Here", "bodies_of", "compile_here", "payload_numbers", "placed"]

Shape = int | tuple[int, ...]
GIVEN: Mapping[str, tuple[int, ...]] = {"base": (4, 4), "tool": (4, 4), "gravity": (3,), "payload": (10,)}
"""Inputs that any kernel of an arm may have beside its own: T_w0, T_nt, gravity in the world (m/s2), and a body more on
the joint that carries the tool, in its frame: mass, first moment (3), second moment (xx, yy, zz, xy, yz, xz)."""

NEEDED = "needed"
"""Option "given" of a kernel: those of `GIVEN` that its equation reads."""


class Here(NamedTuple):
    """An arm as an equation sees it: its model, of which some may be scalars that are traced, and what it carries."""

    model: ArmModel
    payload: Inertial | None = None

    @property
    def bodies(self) -> list[Inertial]:
        """Inertial parameters of the links, the payload on that which carries the tool.

        Raises
        ------
        MissingInertia
            The model states none.
        """
        found = bodies_of(self.model)
        if self.payload is not None:
            found[self.model.tool_joint] = merged(found[self.model.tool_joint], self.payload)
        return found


def bodies_of(model: ArmModel) -> list[Inertial]:
    """Return the inertial parameters of the links.

    Raises
    ------
    MissingInertia
        The model states none.
    """
    if model.bodies is None:
        if model.no_inertia:
            raise MissingInertia(f"arm {model.name!r} has kinematics only: {model.no_inertia}")
        raise MissingInertia(
            f"arm {model.name!r} states no masses and inertias, so it has kinematics only; "
            "give bodies (mass, com, inertia per link; <inertial> in a URDF) for dynamics"
        )
    return links_with_rotors(model, model.bodies)


def placed(model: ArmModel, given: Mapping[str, Vector]) -> Here:
    """The arm with some of `GIVEN` in place of what its model states."""
    parts: dict[str, Any] = {name: _rows(T) for name, T in given.items() if name in ("base", "tool")}
    if "gravity" in given:
        parts["gravity"] = tuple(given["gravity"])
    payload = None
    if "payload" in given:
        m, hx, hy, hz, xx, yy, zz, xy, yz, xz = given["payload"]
        payload = Inertial(m, [hx, hy, hz], [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Here(dataclasses.replace(model, **parts), payload)


def _rows(T: Vector) -> tuple[tuple[Any, ...], ...]:
    return tuple(tuple(T[4 * i : 4 * i + 4]) for i in range(4))


def payload_numbers(body: Inertial) -> list[float]:
    """The ten numbers of a payload."""
    S = body.S
    numbers = [body.m, *body.h, S[0][0], S[1][1], S[2][2], S[0][1], S[1][2], S[0][2]]
    return [float(x) for x in numbers]


def compile_here(
    model: ArmModel,
    options: Mapping[str, Any],
    equation: Callable[..., Any],
    inputs: Mapping[str, Shape],
    outputs: Mapping[str, Shape],
    *,
    name: str,
    **more: Any,
) -> Kernel:
    """Trace `equation(here, *inputs)`; those of `GIVEN` that the option "given" names are inputs after its own.

    The option may also be `NEEDED`.

    Raises
    ------
    UnknownName
        Something else is named.
    """
    needed = options.get("given") == NEEDED
    given: Sequence[str] = tuple(GIVEN) if needed else options.get("given", ())
    for wanted in given:
        if wanted not in GIVEN:
            raise UnknownName("input of an arm's kernels", str(wanted), GIVEN)
    if not given:
        return compile(functools.partial(equation, Here(model)), inputs, outputs, name=f"{model.name}_{name}", **more)

    def anywhere(*arrays: Vector) -> Any:
        own, rest = arrays[: len(inputs)], arrays[len(inputs) :]
        return equation(placed(model, dict(zip(given, rest, strict=True))), *own)

    whole = {**inputs, **{wanted: GIVEN[wanted] for wanted in given}}
    found = compile(anywhere, whole, outputs, name=f"{model.name}_{name}_anywhere", **more)
    return found.without([name for name in GIVEN if name not in found.reads]) if needed else found
