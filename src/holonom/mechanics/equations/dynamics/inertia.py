"""The ten inertial parameters of a link, in the form in which the equations of motion are linear in them."""

from __future__ import annotations

from typing import NamedTuple

from holonom.mechanics.equations.vectors import Matrix, Vector, add, matmul, matvec, scale, transpose
from holonom.model import Body
from holonom.trace import Number

__all__ = ["Inertial", "fixed_to_body", "from_body", "merged", "moved", "point_mass"]


class Inertial(NamedTuple):
    """Mass m, first moment h = m c and second moment S = sum of m r r^T about the link frame's origin.

    Together they are the pseudo-inertia matrix [S h; h^T m] (Wensing, Kim, Slotine 2018); the rotational inertia is
    I = tr(S) 1 - S.
    """

    m: Number
    h: list[Number]
    S: list[list[Number]]

    def rotational(self) -> list[list[Number]]:
        """I = tr(S) 1 - S, about the frame's origin."""
        S = self.S
        xx, yy, zz = S[1][1] + S[2][2], S[0][0] + S[2][2], S[0][0] + S[1][1]
        return [[xx, -S[0][1], -S[0][2]], [-S[0][1], yy, -S[1][2]], [-S[0][2], -S[1][2], zz]]


def from_body(body: Body) -> Inertial:
    """From mass, centre of mass and the inertia about it."""
    xx, yy, zz, xy, yz, xz = body.inertia
    half = 0.5 * (xx + yy + zz)
    S = [[half - xx, -xy, -xz], [-xy, half - yy, -yz], [-xz, -yz, half - zz]]
    spread = Inertial(0.0, [0.0, 0.0, 0.0], [list(row) for row in S])
    return merged(spread, point_mass(body.mass, body.com))


def point_mass(m: Number, c: Vector) -> Inertial:
    """A point mass at c."""
    h = scale(m, c)
    return Inertial(m, h, [[h[i] * c[j] for j in range(3)] for i in range(3)])


def merged(a: Inertial, b: Inertial) -> Inertial:
    """Both together; they must be stated in the same frame."""
    return Inertial(a.m + b.m, add(a.h, b.h), [add(p, r) for p, r in zip(a.S, b.S, strict=True)])


def moved(a: Inertial, R: Matrix, p: Vector) -> Inertial:
    """The same body stated in a frame in which its own frame has the pose (R, p)."""
    Rh = matvec(R, a.h)
    RS = matmul(matmul(R, a.S), transpose(R))
    S = [[RS[i][j] + Rh[i] * p[j] + p[i] * Rh[j] + (a.m * p[i]) * p[j] for j in range(3)] for i in range(3)]
    return Inertial(a.m, add(Rh, scale(a.m, p)), S)


def fixed_to_body(link: Body, load: Body) -> Body:
    """Return the link with a load fixed to it, both stated in the link frame."""
    whole = merged(from_body(link), from_body(load))
    m = float(whole.m)
    c = [float(h) / m for h in whole.h] if m else [0.0, 0.0, 0.0]
    about_c = merged(whole, Inertial(-m, [-m * x for x in c], [[-m * x * y for y in c] for x in c]))
    I = about_c.rotational()
    return Body(
        m,
        (c[0], c[1], c[2]),
        (float(I[0][0]), float(I[1][1]), float(I[2][2]), float(I[0][1]), float(I[1][2]), float(I[0][2])),
    )
