"""Small systems of equations in compiled loops."""

from __future__ import annotations

from holonom.trace.code.loops import loop

__all__ = ["solve_positive3", "solve_positive4"]

FLAGS = {"contract"}


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def solve_positive3(
    xx: float, yy: float, ww: float, xy: float, xw: float, yw: float, bx: float, by: float, bw: float
) -> tuple[float, float, float]:
    """Solve a symmetric positive 3 x 3 system by its cofactors: one division."""
    x0, y0, w0 = yy * ww - yw * yw, xw * yw - xy * ww, xy * yw - xw * yy
    y1, w1, w2 = xx * ww - xw * xw, xy * xw - xx * yw, xx * yy - xy * xy
    part = 1.0 / (xx * x0 + xy * y0 + xw * w0)
    return (
        part * (x0 * bx + y0 * by + w0 * bw),
        part * (y0 * bx + y1 * by + w1 * bw),
        part * (w0 * bx + w1 * by + w2 * bw),
    )


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def solve_positive4(
    block: tuple[float, float, float, float, float, float],
    border: tuple[float, float, float, float],
    right: tuple[float, float, float, float],
) -> tuple[float, float, float, float]:
    """Solve a symmetric positive 4 x 4 system: the last unknown is eliminated, the others by `solve_positive3`.

    `block` are xx, yy, ww, xy, xw, yw; `border` xp, yp, wp, pp; `right` the right sides.
    """
    xx, yy, ww, xy, xw, yw = block
    xp, yp, wp, pp = border
    bx, by, bw, bp = right
    part = 1.0 / pp
    x, y, w = solve_positive3(
        xx - part * xp * xp, yy - part * yp * yp, ww - part * wp * wp,
        xy - part * xp * yp, xw - part * xp * wp, yw - part * yp * wp,
        bx - part * xp * bp, by - part * yp * bp, bw - part * wp * bp,
    )  # fmt: skip
    return x, y, w, part * (bp - xp * x - yp * y - wp * w)
