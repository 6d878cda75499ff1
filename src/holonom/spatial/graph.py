"""Transformation graphs: known poses between named frames, one unknown edge solved from the rest (spec. 1.1)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import ModelError, UnknownName
from holonom.spatial.poses import check_pose, inverse

__all__ = ["PoseGraph"]


class PoseGraph:
    """Frames by name and the poses known between some of them.

    Parameters
    ----------
    edges
        ("a", "b") -> T_ab (4, 4): frame b expressed in frame a. Inner letters meet: T_wt = T_wb T_b0 T_0n T_nt.
    """

    def __init__(self, edges: Mapping[tuple[str, str], ArrayLike]) -> None:
        self._ways: dict[str, dict[str, Array]] = {}
        for (a, b), T in edges.items():
            known = check_pose(T, f"T_{a}{b}")
            self._ways.setdefault(a, {})[b] = known
            self._ways.setdefault(b, {})[a] = inverse(known)

    def between(self, a: str, b: str) -> Array:
        """T_ab along the shortest way of known edges.

        Raises
        ------
        UnknownName
            A frame that is not in the graph.
        ModelError
            Nothing connects the two frames.
        """
        if a == b:
            return np.eye(4)
        for frame in (a, b):
            if frame not in self._ways:
                raise UnknownName("frame", frame, self._ways)
        reached = {a: np.eye(4)}
        front = [a]
        while front and b not in reached:
            ahead = []
            for here in front:
                for there, T in self._ways[here].items():
                    if there not in reached:
                        reached[there] = reached[here] @ T
                        ahead.append(there)
            front = ahead
        if b not in reached:
            raise ModelError(f"no chain of known poses leads from frame {a!r} to frame {b!r}; state one more edge")
        return reached[b]

    def solve(self, a: str, b: str, c: str, d: str, T_cd: ArrayLike) -> Array:
        """The unknown edge T_ab for which T_cd comes out as given: T_ab = T_ac T_cd T_db.

        `a` and `c`, and `b` and `d`, must be connected by known edges (for instance: where must the base "b" stand in
        the world "w", so that tool "t" is at T_wt? `solve("w", "b", "w", "t", T_wt)`).
        """
        return self.between(a, c) @ check_pose(T_cd, f"T_{c}{d}") @ self.between(d, b)
