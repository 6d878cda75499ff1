"""Formulas: the textbook's planar arm letter by letter, and every arm's formulas against its floats."""

import dataclasses
import sys

import numpy as np
import pytest
from arms import random_model, random_tree

from holonom.errors import InputError, MissingInertia, UnknownName
from holonom.mechanics import load_arm
from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import composite_body, coriolis, forward_dynamics, newton_euler
from holonom.mechanics.kernels.table import bodies_of
from holonom.mechanics.symbolic import QUANTITIES, formulas
from holonom.model import Body, DHRow, arm_model_from_dh, preset

sympy = pytest.importorskip("sympy", reason="SymPy is not installed (extra 'symbolic')")

LENGTHS = {"a1": "l1", "a2": "l2"}
LETTERS = LENGTHS | {"cx1": "a1", "cx2": "a2", "Izz1": "I1", "Izz2": "I2"}


def planar():
    """Two links in a vertical plane: lengths l, centres of mass at a, gravity along -y."""
    bodies = [
        Body(2.0, (-0.3, 0.0, 0.0), (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)),
        Body(1.5, (-0.2, 0.0, 0.0), (0.0, 0.0, 0.05, 0, 0, 0)),
    ]
    arm = arm_model_from_dh([DHRow(a=0.5), DHRow(a=0.4)], convention="standard", name="planar", bodies=bodies)
    return dataclasses.replace(arm, gravity=(0.0, -9.81, 0.0))


def letters(text):
    return [sympy.Symbol(name, real=True) for name in text.split()]


def test_the_planar_arm_reads_as_in_the_book():
    """Craig 6.7; Siciliano 7.3.2 without rotors."""
    assert formulas(planar(), "inverse_dynamics", names=LETTERS).text == (
        "tau1 = (I1 + I2 + m1*a1^2 + m2*(l1^2 + a2^2 + 2*l1*a2*c2))*qdd1 + (I2 + m2*(a2^2 + l1*a2*c2))*qdd2"
        " - 2*m2*l1*a2*s2*qd1*qd2 - m2*l1*a2*s2*qd2^2 + (m1*a1 + m2*l1)*g*c1 + m2*a2*g*c12\n"
        "tau2 = (I2 + m2*(a2^2 + l1*a2*c2))*qdd1 + (I2 + m2*a2^2)*qdd2 + m2*l1*a2*s2*qd1^2 + m2*a2*g*c12"
    )
    assert formulas(planar(), "fk", names=LENGTHS).text.splitlines()[:3] == [
        "x = l1*c1 + l2*c12",
        "y = l1*s1 + l2*s12",
        "R11 = c12",
    ]
    assert formulas(planar(), "jacobian", names=LENGTHS).text.splitlines()[:2] == [
        "J11 = -l1*s1 - l2*s12",
        "J12 = -l2*s12",
    ]
    assert formulas(planar(), "coriolis_matrix", names=LETTERS).text == (
        "C11 = -m2*l1*a2*s2*qd2\nC12 = -m2*l1*a2*s2*qd1 - m2*l1*a2*s2*qd2\nC21 = m2*l1*a2*s2*qd1"
    )


def test_latex():
    assert formulas(planar(), "gravity", names=LETTERS).latex == (
        r"g_{1} = \left(m_{1} a_{1} + m_{2} l_{1}\right) g c_{1} + m_{2} a_{2} g c_{12} \\"
        "\n"
        r"g_{2} = m_{2} a_{2} g c_{12}"
    )
    assert r"\ddot{q}_{1}" in formulas(planar(), "inverse_dynamics").latex
    assert r"I_{zz1}" in formulas(planar(), "mass_matrix").latex
    assert r"\cos(2 q_{2})" in formulas(planar(), "forward_dynamics").latex


def test_the_book_by_algebra_with_rotors():
    """Siciliano 7.3.2, 7.82 and 7.84; motor 2 sits on link 1, and its locked rotor is part of that link here."""
    model = dataclasses.replace(preset("planar2r"), rotors="full")
    a1, l1, l2, m1, m2, I1, I2, k1, k2, Im1, Im2, g = letters("a1 cx1 cx2 m1 m2 Izz1 Izz2 k1 k2 Im1 Im2 g")
    q1, q2, qd1, qd2, qdd1, qdd2 = letters("q1 q2 qd1 qd2 qdd1 qdd2")
    c1, c2, s2, c12 = sympy.cos(q1), sympy.cos(q2), sympy.sin(q2), sympy.cos(q1 + q2)
    b11 = I1 + m1 * l1**2 + k1**2 * Im1 + I2 + m2 * (a1**2 + l2**2 + 2 * a1 * l2 * c2)
    b12 = I2 + m2 * (l2**2 + a1 * l2 * c2) + k2 * Im2
    b22 = I2 + m2 * l2**2 + k2**2 * Im2
    h = -m2 * a1 * l2 * s2
    book = (
        b11 * qdd1 + b12 * qdd2 + 2 * h * qd1 * qd2 + h * qd2**2 + (m1 * l1 + m2 * a1) * g * c1 + m2 * l2 * g * c12,
        b12 * qdd1 + b22 * qdd2 - h * qd1**2 + m2 * l2 * g * c12,
    )
    found = formulas(model, "inverse_dynamics")
    assert [sympy.simplify(ours - theirs) for ours, theirs in zip(found.expressions, book, strict=True)] == [0, 0]
    mass = formulas(model, "mass_matrix").expressions
    assert [sympy.simplify(e - b) for e, b in zip(mass, (b11, b12, b12, b22), strict=True)] == [0, 0, 0, 0]
    C = formulas(model, "coriolis_matrix").expressions
    assert [sympy.simplify(e - b) for e, b in zip(C, (h * qd2, h * (qd1 + qd2), -h * qd1, 0), strict=True)] == [0] * 4


def evaluated(found, q, qd, third):
    """The expressions as numbers; `third` holds accelerations and torques alike."""
    n = len(q)
    known = dict(found.values)
    for name, v in (("q", q), ("qd", qd), ("qdd", third), ("tau", third)):
        known |= {f"{name}{k + 1}": v[k] for k in range(n)}
    return np.array(
        [sympy.lambdify(letters(" ".join(known)), e)(*known.values()) for e in found.expressions], dtype=float
    )


def floats(model, what, q, qd, third):
    """The same from the equations, on floats."""
    bodies = None if what in ("fk", "jacobian") else bodies_of(model)
    rest = [0.0] * len(q)
    if what == "fk":
        T = np.reshape(kinematics.pose(model, q, None), (4, 4)).astype(float)
        return np.concatenate([T[:3, 3], T[:3, :3].ravel()])
    value = {
        "jacobian": lambda: kinematics.jacobian(model, q, "world"),
        "mass_matrix": lambda: composite_body.mass_matrix(model, bodies, q),
        "coriolis_matrix": lambda: coriolis.coriolis_matrix(model, bodies, q, qd),
        "gravity": lambda: newton_euler.inverse_dynamics(model, bodies, q, rest, rest),
        "inverse_dynamics": lambda: newton_euler.inverse_dynamics(model, bodies, q, qd, third),
        "forward_dynamics": lambda: forward_dynamics.forward_dynamics(model, bodies, q, qd, third),
    }[what]()
    return np.array(value, dtype=float).ravel()


SMALL = [planar(), random_model(1, 2), random_tree(5, 4)]
SMALL += [preset(name) for name in ("pendulum", "three_joint", "scara", "planar2r")]
CASES = [(m, what) for m in SMALL for what in QUANTITIES if what != "forward_dynamics" or len(m.independent) <= 2]
CASES += [(preset(name), what) for name in ("puma560", "stanford", "ur5e") for what in ("fk", "jacobian", "gravity")]
CASES += [(preset("puma560"), "mass_matrix")]
CASES = [(m, what) for m, what in CASES if m.bodies is not None or what in ("fk", "jacobian")]


@pytest.mark.parametrize("values", ["symbols", "numbers"])
@pytest.mark.parametrize(("model", "what"), CASES, ids=[f"{m.name}-{what}" for m, what in CASES])
def test_formulas_have_the_values_of_the_equations(model, what, values):
    rng = np.random.default_rng(9)
    q, qd, third = rng.uniform(-1.5, 1.5, (3, len(model.independent))).tolist()
    found = formulas(model, what, values=values, digits=13)
    ours, theirs = evaluated(found, q, qd, third), floats(model, what, q, qd, third)
    ours = ours[: len(theirs)]  # the determinant is the last of forward dynamics
    np.testing.assert_allclose(ours, theirs, atol=1e-8 * max(1.0, np.abs(theirs).max()))


def test_numbers_are_short():
    assert formulas(planar(), "gravity", values="numbers", digits=4).text == (
        "g1 = 11.28*c1 + 2.943*c12\ng2 = 2.943*c12"  # 2 * 0.2 * 9.81 + 1.5 * 0.5 * 9.81 = 11.28
    )
    assert formulas(planar(), "gravity", values="numbers").values == {}


def test_parallel_axes_add_their_angles_and_others_do_not():
    text = formulas(preset("puma560"), "fk").text
    assert "c23" in text
    assert "c12" not in text
    assert text.splitlines()[2].startswith("z = d1 + ")


def test_bad_requests_say_what_there_is():
    with pytest.raises(UnknownName, match=r"there is coriolis_matrix, .* did you mean 'mass_matrix'\?"):
        formulas(planar(), "mass_matrx")
    with pytest.raises(UnknownName, match="no letter 'L1'; there is Izz1, "):
        formulas(planar(), "gravity", names={"L1": "l1"})
    with pytest.raises(UnknownName, match="no kind of values 'letters'"):
        formulas(planar(), values="letters")
    with pytest.raises(InputError, match="forward dynamics of 6 joints"):
        formulas(preset("puma560"), "forward_dynamics")
    with pytest.raises(MissingInertia):
        formulas(dataclasses.replace(planar(), bodies=None))


def test_without_sympy_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(InputError, match=r"pip install -e '\.\[symbolic\]'"):
        formulas(planar())


def test_an_arm_serves_as_well_as_its_model():
    arm = load_arm("planar2r")
    assert formulas(arm, "mass_matrix").text == formulas(arm.model, "mass_matrix").text
