"""Which closed-form inverse an arm has: a table of recognisers, each for one way in which its axes lie.

=====================  ==========================================================================  ========
family                 axes                                                                        task
=====================  ==========================================================================  ========
spherical wrist        4, 5, 6 meet; the first three as in `REGIONS`. Or of five joints 3, 4, 5    pose
spherical shoulder     the same built the other way round: 1, 2, 3 meet                            pose
three parallel         2 || 3 || 4 with any 5 and 6 (UR: they meet); or 3 || 4 || 5 with any 1, 2  pose
five joints            4 meets 5; 3 meets 4; 2 || 3 || 4; 1 || 2 || 3; or the mirror of these      pose
four joints            any, the first three or their mirror as in `REGIONS`; or 1 || 2 || 3        pose
planar                 three parallel turns, at most one joint sliding along them (3R, SCARA)      pose
planar point           two parallel turns, at most one joint sliding along them                    position
three joints           as the first three joints of a spherical-wrist arm                          position
=====================  ==========================================================================  ========

Branch names. `righty` and `lefty`: the arm stands right or left of the line from axis 1 to the wrist, as the Puma's
(`front` and `back` where it has no lateral offset: facing the wrist, or bent over backwards); for planar arms the
elbow is right or left of the line from joint 1 to the tool. `above` and `below`: the elbow, against the line from
shoulder to wrist. `noflip` and `flip`: the middle joint of the wrist on the positive or negative side of straight.
`q3+` and `q3-`: joint 3 on the larger or smaller side of where both solutions meet. `det+ first`, `det+ second`,
`det- first` and `det- second`: the roots of a quartic, by the sign of the determinant of the first three joints'
Jacobian at the wrist (or tool), then by q3 from -pi to pi, counted from the home position. The sign of a branch that is
reached lasts until it is singular. The number lasts until another branch of its sign appears, ends, or is passed by q3
at the cut: no name could do more, for some of these arms pass from one solution to another without a singularity
between (cuspidal arms, Wenger 1992). Follow branches with `mechanics.paths`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, NamedTuple

import numpy as np

from holonom.mechanics.equations.inverse.few_joints import middle_meeting, middle_parallel, planar_shoulder, short_wrist
from holonom.mechanics.equations.inverse.general_arm import NAMES, general
from holonom.mechanics.equations.inverse.parallel_axes import planar_point, planar_pose, three_parallel
from holonom.mechanics.equations.inverse.regional import (
    Regional,
    backwards,
    meeting_12,
    parallel_12_slide,
    parallel_23,
    two_turns,
)
from holonom.mechanics.equations.inverse.skew_wrist import three_parallel_and_two, three_parallel_skew
from holonom.mechanics.equations.inverse.spherical_wrist import spherical_wrist
from holonom.mechanics.equations.inverse.subproblems import Branch, Screw, mirrored, opposite
from holonom.mechanics.equations.vectors import Pose, Vector, scale, transpose, tvec
from holonom.mechanics.kernels.inverse.screws import ALIKE, ScrewChain, common_point, parallel, screw_chain
from holonom.model import ArmModel

__all__ = ["FAMILIES", "REGIONS", "ClosedForm", "closed_form"]

Names = Sequence[str]
CALIBRATED = 5e-3
"""Sine or length (m) up to which axes of a calibrated arm may miss being parallel or meeting."""
ROUNDING = 5e-9
"""What an arm may depart from its closed form without refinement (pi / 2 with ten digits)."""


class Recipe(NamedTuple):
    """An inverse: what is asked of it, branch names in the order of the equation, and the equation.

    A pose task's equation takes the motion G = (R, p) from the home pose; a position task's the tool's place.
    """

    task: Literal["pose", "position"]
    names: Names
    equation: Callable[..., list[Branch]]


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """The closed-form inverse of one arm; branches come in the order of `names`."""

    family: str
    chain: ScrewChain
    recipe: Recipe
    names: tuple[str, ...]

    @property
    def task(self) -> Literal["pose", "position"]:
        """Whether a whole pose is asked for, or the place of the tool only."""
        return self.recipe.task

    @property
    def exact(self) -> bool:
        """Whether the arm is what the form takes it for, but for rounding in the file that states it."""
        return self.chain.departure < ROUNDING

    def branches(self, target: Pose | Vector) -> list[Branch]:
        """Joint values relative to `chain.reference`, a branch per name."""
        found = self.recipe.equation(target)
        order = dict(zip(self.recipe.names, found, strict=True))
        return [order[name] for name in self.names]


class Region(NamedTuple):
    """Three joints that bring a point somewhere: their screws, the equation, and its branch names."""

    screws: Sequence[Screw]
    solve: Regional
    names: Names


def closed_form(model: ArmModel) -> ClosedForm | None:
    """The closed-form inverse of an arm, if its axes lie as one of `FAMILIES` wants, or nearly so.

    A calibrated arm's axes are off by what its maker could not make better: the nominal arm's branches are refined.
    """
    for alike in (ALIKE, CALIBRATED):
        chain = screw_chain(model, alike)
        if chain is None:
            return None
        for family, recognise in FAMILIES.items():
            recipe = recognise(chain)
            if recipe is not None:
                return ClosedForm(family, chain, recipe, tuple(sorted(recipe.names, key=_rank)))
    return None


_ORDER = ("righty", "front", "lefty", "back", "above", "below", "noflip", "flip")


def _rank(name: str) -> list[tuple[int, str]]:
    return [(_ORDER.index(w) if w in _ORDER else len(_ORDER), w) for w in name.split()]


def _named(*choices: Names) -> list[str]:
    return [" ".join(words) for words in product(*choices)]


# --- the first three joints -------------------------------------------------------------------------------------------


def _kinds(screws: Sequence[Screw]) -> str:
    return "".join("R" if s.revolute else "P" for s in screws)


def _elbow_names(screws: Sequence[Screw], wrist: Vector) -> list[str]:
    """Names for `parallel_23`: q1's larger sine first (the wrist towards h1 x h2), then q3's larger angle."""
    (h1, p1), (h2, p2), h3 = (np.array(screws[0][1:3]), np.array(screws[1][1:3]), np.array(screws[2].h))
    lateral, ahead = h2 @ (np.array(wrist) - p1), np.cross(h1, h2) @ (p2 - p1)
    pair = ("righty", "lefty") if abs(lateral) > ALIKE else ("front", "back")
    side = lateral if abs(lateral) > ALIKE else ahead
    shoulders = pair if side >= -ALIKE else pair[::-1]
    rising = ("below", "above") if h2 @ h3 > 0.0 else ("above", "below")
    return [f"{shoulders[k]} {elbow}" for k in (0, 1) for elbow in (rising if k == 0 else rising[::-1])]


def _parallel_23(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "RRR" or not parallel(screws[1], screws[2]) or parallel(screws[0], screws[1]):
        return None
    return Region(screws, parallel_23, _elbow_names(screws, c))


def _parallel_12(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "RRR" or not parallel(screws[0], screws[1]) or parallel(screws[1], screws[2]):
        return None
    return Region(screws, backwards(parallel_23), _named(("q3+", "q3-"), ("q1-", "q1+")))


def _parallel_12_slide(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "RRP" or not parallel(screws[0], screws[1]):
        return None
    if abs(np.dot(screws[0].h, screws[2].h)) < ALIKE:
        return None
    return Region(screws, parallel_12_slide, ("q2+", "q2-"))


def _slide_parallel_23(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "PRR" or _parallel_12_slide(screws[::-1], c) is None:
        return None
    return Region(screws, backwards(parallel_12_slide), ("q2-", "q2+"))


def _meeting_12(screws: Sequence[Screw], c: Vector) -> Region | None:
    o = common_point(screws[0], screws[1])
    if _kinds(screws) not in ("RRR", "RRP") or o is None:
        return None
    placed = [screws[0]._replace(p=o), *screws[1:]]
    return Region(placed, meeting_12, _named(("q3+", "q3-"), ("q1-", "q1+")))


def _meeting_23(screws: Sequence[Screw], c: Vector) -> Region | None:
    o = common_point(screws[1], screws[2])
    if _kinds(screws) not in ("RRR", "PRR") or o is None:
        return None
    placed = [*screws[:2], screws[2]._replace(p=o)]
    return Region(placed, backwards(meeting_12), _named(("q1-", "q1+"), ("q3+", "q3-")))


def _any(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "RRR" or parallel(screws[0], screws[1]) or parallel(screws[1], screws[2]):
        return None
    return Region(screws, general, NAMES)


def _two_turns(screws: Sequence[Screw], c: Vector) -> Region | None:
    if _kinds(screws) != "RR":
        return None
    return Region(screws, two_turns, ("q2+", "q2-") if parallel(*screws) else ("q1-", "q1+"))


REGIONS: Mapping[str, Callable[[Sequence[Screw], Vector], Region | None]] = {
    "2 parallel to 3": _parallel_23,
    "1 parallel to 2": _parallel_12,
    "1 parallel to 2, 3 slides": _parallel_12_slide,
    "1 slides, 2 parallel to 3": _slide_parallel_23,
    "1 meets 2": _meeting_12,
    "2 meets 3": _meeting_23,
    "any three turns": _any,
}


def _region(screws: Sequence[Screw], c: Vector) -> Region | None:
    return next((r for recognise in REGIONS.values() if (r := recognise(screws, c)) is not None), None)


# --- whole arms -------------------------------------------------------------------------------------------------------


def _with_wrist(screws: Sequence[Screw]) -> Recipe | None:
    """Six joints, or five, of which the last three meet."""
    if len(screws) not in (5, 6) or _kinds(screws[-3:]) != "RRR":
        return None
    s4, s5, s6 = screws[-3:]
    o, o5 = common_point(s4, s5), common_point(s5, s6)
    if o is None or o5 is None or np.linalg.norm(np.subtract(o, o5)) > ALIKE:
        return None
    region = _region(screws[:3], o) if len(screws) == 6 else _two_turns(screws[:2], o)
    if region is None:
        return None
    placed = [*region.screws, s4._replace(p=o), s5, s6]
    names = _named(region.names, ("noflip", "flip"))
    return Recipe("pose", names, lambda G: spherical_wrist(placed, region.solve, G))


def _ur(screws: Sequence[Screw]) -> Recipe | None:
    if _kinds(screws) != "RRRRRR" or not parallel(screws[1], screws[2]) or not parallel(screws[1], screws[3]):
        return None
    o = common_point(screws[4], screws[5])
    if o is None or parallel(screws[0], screws[1]) or parallel(screws[3], screws[4]):
        return None
    placed = [*screws[:4], *(s._replace(p=o) for s in screws[4:])]
    arms = _elbow_names(screws, o)
    names = [f"{arms[2 * k + e]} {wrist}" for k in (0, 1) for wrist in ("noflip", "flip") for e in (0, 1)]
    return Recipe("pose", names, lambda G: three_parallel(placed, G))


def _forwards(recognise: Callable[[Sequence[Screw]], Recipe | None]) -> Callable[[ScrewChain], Recipe | None]:
    return lambda chain: recognise(chain.screws)


def _backwards(recognise: Callable[[Sequence[Screw]], Recipe | None]) -> Callable[[ScrewChain], Recipe | None]:
    """The recogniser of the arms that are built the other way round: G^-1 = E6(-q6) ... E1(-q1)."""

    def backwards_(chain: ScrewChain) -> Recipe | None:
        recipe = recognise([mirrored(s) for s in reversed(chain.screws)])
        if recipe is None:
            return None

        def equation(G: Pose) -> list[Branch]:
            R, p = G
            inverse = (transpose(R), scale(-1.0, tvec(R, p)))
            return [Branch([opposite(v) for v in reversed(b.values)], b.free) for b in recipe.equation(inverse)]

        return Recipe("pose", [f"backwards {name}" for name in recipe.names], equation)

    return backwards_


def _skew(screws: Sequence[Screw]) -> Recipe | None:
    if _kinds(screws) != "RRRRRR" or not parallel(screws[1], screws[2]) or not parallel(screws[1], screws[3]):
        return None
    if parallel(screws[0], screws[1]) or parallel(screws[3], screws[4]):
        return None
    if parallel(screws[4], screws[5]):
        names = _named(("q1-", "q1+"), ("q5+", "q5-"), _elbows(screws[1:3]))
        return Recipe("pose", names, lambda G: three_parallel_and_two(screws, G))
    names = _named(("first", "second", "third", "fourth"), _elbows(screws[1:3]))
    return Recipe("pose", names, lambda G: three_parallel_skew(screws, G))


def _elbows(screws: Sequence[Screw]) -> tuple[str, str]:
    """Names of both ways of two parallel turns, the second's larger angle first."""
    return ("righty", "lefty") if np.dot(screws[0].h, screws[1].h) > 0.0 else ("lefty", "righty")


def _short_wrist(screws: Sequence[Screw]) -> Recipe | None:
    """Four joints, or five of which the last two meet."""
    if len(screws) not in (4, 5) or "P" in _kinds(screws[3:]):
        return None
    last = screws[3:]
    c = common_point(screws[2], screws[3]) or screws[3].p if len(last) == 1 else common_point(*last)
    region = None if c is None else _region(screws[:3], c)
    if c is None or region is None:
        return None
    placed = [*region.screws, *(s._replace(p=c) for s in last)]
    return Recipe("pose", region.names, lambda G: short_wrist(placed, region.solve, G))


def _middle_meeting(screws: Sequence[Screw]) -> Recipe | None:
    """Five joints, of which 3 meets 4."""
    if _kinds(screws) != "RRRRR" or (c := common_point(screws[2], screws[3])) is None:
        return None
    alike = parallel(screws[0], screws[1])
    names = _named(("q5-", "q5+"), ("q2+", "q2-")) if alike else NAMES
    placed = [*screws[:2], *(s._replace(p=c) for s in screws[2:4]), screws[4]]
    return Recipe("pose", names, lambda G: middle_meeting(placed, parallel_23 if alike else general, G))


def _middle_parallel(screws: Sequence[Screw]) -> Recipe | None:
    if _kinds(screws) != "RRRRR" or not parallel(screws[1], screws[2]) or not parallel(screws[1], screws[3]):
        return None
    if parallel(screws[0], screws[1]) or parallel(screws[3], screws[4]):
        return None
    return Recipe("pose", _elbow_names(screws, screws[4].p), lambda G: middle_parallel(screws, G))


def _planar_shoulder(screws: Sequence[Screw]) -> Recipe | None:
    """Three parallel turns, then one or two joints of other directions."""
    if _kinds(screws) not in ("RRRR", "RRRRR") or not all(parallel(screws[0], s) for s in screws[1:3]):
        return None
    if parallel(screws[2], screws[3]):
        return None
    elbows = _elbows(screws)
    if len(screws) == 4:
        return Recipe("pose", elbows, lambda G: planar_shoulder(screws, G, meeting=False))
    o = common_point(*screws[3:])
    placed = screws if o is None else [*screws[:3], *(s._replace(p=o) for s in screws[3:])]
    names = _named(("q4+", "q4-"), elbows)
    return Recipe("pose", names, lambda G: planar_shoulder(placed, G, meeting=o is not None))


def _planar(chain: ScrewChain) -> Recipe | None:
    """Two or three parallel turns, at most one joint sliding along them."""
    screws = chain.screws
    turning = [s for s in screws if s.revolute]
    if len(turning) not in (2, 3) or len(screws) - len(turning) > 1 or len(screws) < 2:
        return None
    if not all(parallel(turning[0], s) for s in screws):
        return None
    elbow = _elbows(turning)
    if len(turning) == 3:
        return Recipe("pose", elbow, lambda G: planar_pose(screws, G))
    tool = [row[3] for row in chain.home[:3]]
    return Recipe("position", elbow, lambda w: planar_point(screws, tool, w))


def _three_joints(chain: ScrewChain) -> Recipe | None:
    tool = [row[3] for row in chain.home[:3]]
    region = _region(chain.screws, tool) if len(chain.screws) == 3 else None
    if region is None:
        return None
    return Recipe("position", region.names, lambda w: region.solve(region.screws, tool, w))


FAMILIES: Mapping[str, Callable[[ScrewChain], Recipe | None]] = {
    "spherical wrist": _forwards(_with_wrist),
    "three parallel axes": _forwards(_ur),
    "planar": _planar,
    "three joints": _three_joints,
    "spherical shoulder": _backwards(_with_wrist),
    "three parallel axes, backwards": _backwards(_ur),
    "three parallel axes, skew wrist": _forwards(_skew),
    "three parallel axes, skew shoulder": _backwards(_skew),
    "five joints, three parallel": _forwards(_middle_parallel),
    "four or five joints": _forwards(_short_wrist),
    "four or five joints, backwards": _backwards(_short_wrist),
    "planar shoulder": _forwards(_planar_shoulder),
    "planar wrist": _backwards(_planar_shoulder),
    "five joints, 3 meets 4": _forwards(_middle_meeting),
    "five joints, 2 meets 3": _backwards(_middle_meeting),
}
