"""Values, expressions, control flow and routines, seen from what a program types."""

from __future__ import annotations

import math

import numpy as np
import pytest
from arps_machine import FakeMachine, run, said
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from holonom.errors import ProgramError, ProgramFault
from holonom.lang import Part, compile_program, poses

finite = st.floats(-1e6, 1e6).map(lambda x: round(x, 6))
angle = st.floats(-179.0, 179.0)


@pytest.mark.parametrize(
    ("expression", "result"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("10 - 4 - 3", 3),
        ("2 ^ 3", 8),
        ("-2 ^ 2", -4),
        ("2 ^ -1", 0.5),
        ("7 MOD 4", 3),
        ("-7 MOD 4", -3),
        ("1 < 2", -1),
        ("2 =< 1", 0),
        ("2 => 2", -1),
        ("1 <> 1", 0),
        ("NOT 1 == 2", -1),
        ("1 == 1 AND 2 == 3 OR TRUE", -1),
        ("TRUE XOR TRUE", 0),
        ("12 BAND 10", 8),
        ("12 BOR 10", 14),
        ("12 BXOR 10", 6),
        ("COM 0", -1),
        ("ABS(-3)", 3),
        ("SQRT(9) + SQR(2)", 7),
        ("SIN(30)", 0.5),
        ("COS(60)", 0.5),
        ("ATAN2(1, -1)", 135),
        ("INT(-2.7)", -2),
        ("FRACT(-2.75)", -0.75),
        ("MIN(3, 1, 2) + MAX(3, 1, 2)", 4),
        ("SIGN(-2) + SIGN(0)", 0),
        ('LEN("abc")', 3),
        ('VAL("  -2.5E1 mm")', -25),
        ('VAL("mm")', 0),
        ('ASC("AB", 2)', 66),
        ('POS("abc", "c")', 3),
        ('"ab" + "c" == "abc"', -1),
        ('"a" < "b"', -1),
        ("DX(TRANS(1, 2, 3)) + DY(TRANS(,5)) + DZ(TRANS(,,7))", 13),
        ("DISTANCE(TRANS(3), TRANS(,4))", 5),
        ("1.5E2 + .5", 150.5),
    ],
)
def test_expression(expression: str, result: float) -> None:
    assert float(said(f"TYPE /F0.9, {expression}")[0]) == pytest.approx(result, abs=1e-9)


@given(finite, finite, finite)
@settings(max_examples=25, deadline=None)
def test_arithmetic_is_that_of_real_numbers(a: float, b: float, c: float) -> None:
    typed = said(f"x = {a:f}\ny = {b:f}\nz = {c:f}\nTYPE /E0.15, x - y * (z + 1) / 8")
    assert float(typed[0]) == pytest.approx(a - b * (c + 1) / 8, rel=1e-12, abs=1e-9)


@given(st.tuples(finite, finite, finite, angle, angle, angle))
@settings(max_examples=100, deadline=None)
def test_transformation_is_zyz_of_scipy(values: tuple[float, ...]) -> None:
    T = poses.transformation(values)
    assert T[:3, :3] == pytest.approx(Rotation.from_euler("ZYZ", values[3:], degrees=True).as_matrix(), abs=1e-12)
    assert T[:3, 3] == pytest.approx(np.array(values[:3]) / 1000)
    assert poses.transformation(poses.angles(T)) == pytest.approx(T, abs=1e-9)


@pytest.mark.parametrize("a", [0.0, 180.0])
def test_angles_where_o_and_t_are_not_told_apart(a: float) -> None:
    T = poses.transformation((1, 2, 3, 20, a, 50))
    assert poses.angles(T)[5] == 0.0
    assert poses.transformation(poses.angles(T)) == pytest.approx(T, abs=1e-12)


def test_tool_down_is_exact() -> None:
    assert np.array_equal(poses.transformation((0, 0, 0, 0, 180, 0))[:3, :3], np.diag([-1.0, 1.0, -1.0]))


@pytest.mark.parametrize(("turn", "axis"), [("RX", "x"), ("RY", "y"), ("RZ", "z")])
def test_turns_about_axes(turn: str, axis: str) -> None:
    machine, _ = run(f"MOVE {turn}(30)")
    expected = Rotation.from_euler(axis, 30, degrees=True).as_matrix()
    assert machine.motions[0].pose[:3, :3] == pytest.approx(expected)


def test_compound_and_inverse() -> None:
    machine, _ = run("SET a = TRANS(1, 2, 3, 40, 50, 60)\nSET b = TRANS(10):RZ(90)\nMOVE INVERSE(a):a:b:TRANS(5)")
    assert machine.motions[0].pose[:3, 3] == pytest.approx([0.010, 0.005, 0])


def test_frame_has_its_axes_where_the_points_say() -> None:
    source = "MOVE FRAME(TRANS(10, 10), TRANS(10, 90), TRANS(-50, 70){})"
    T = run(source.format(""))[0].motions[0].pose
    expected = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    assert T[:3, :3] == pytest.approx(expected)
    assert T[:3, 3] == pytest.approx([0.01, 0.01, 0])
    moved = run(source.format(", TRANS(1, 2, 3)"))[0].motions[0].pose
    assert moved[:3, :3] == pytest.approx(expected)
    assert moved[:3, 3] == pytest.approx([0.001, 0.002, 0.003])


def test_frame_of_collinear_points() -> None:
    with pytest.raises(ProgramFault, match=r"FRAME.*lie on one line"):
        run("MOVE FRAME(NULL, TRANS(10), TRANS(30))")


def test_shift_keeps_the_orientation_and_decompose_gives_the_numbers() -> None:
    source = "SET a = SHIFT(TRANS(1, 2, 3, 10, 20, 30) BY 5, , 7)\nDECOMPOSE v[1] = a\n"
    typed = said(source + 'TYPE /F0.3, v[1], " ", v[2], " ", v[3], " ", v[4], " ", v[5], " ", v[6]')
    assert typed == ["6.000 2.000 10.000 10.000 20.000 30.000"]
    assert said("DECOMPOSE v[] = TRANS(4)\nTYPE v[0]") == ["4"]


def test_loops() -> None:
    assert said("s = 0\nFOR i = 1 TO 4\ns = s + i\nEND\nTYPE s, /X, i") == ["10 5"]
    assert said("FOR i = 3 TO 1 STEP -1\nTYPE i\nEND") == ["3", "2", "1"]
    assert said('FOR i = 1 TO 0\nTYPE "never"\nEND') == []
    assert said("n = 0\nWHILE n < 3 DO\nn = n + 2\nEND\nTYPE n") == ["4"]
    assert said("n = 5\nDO\nn = n + 1\nUNTIL TRUE\nTYPE n") == ["6"]
    assert said("n = 0\n10 n = n + 1\nIF n < 3 GOTO 10\nGOTO out\nn = 99\nout: TYPE n") == ["3"]


@pytest.mark.parametrize(("n", "typed"), [(1, "low"), (2, "low"), (3, "three"), (4, "other")])
def test_case(n: int, typed: str) -> None:
    source = f'CASE {n} OF\nVALUE 1, 2:\nTYPE "low"\nVALUE 3:\nTYPE "three"\nANY\nTYPE "other"\nEND'
    assert said(source) == [typed]


@pytest.mark.parametrize(("n", "typed"), [(1, ["a"]), (2, ["b"]), (3, ["c"]), (4, ["d"])])
def test_if(n: int, typed: list[str]) -> None:
    branches = (
        'IF n == 1 THEN\nTYPE "a"\nELSEIF n == 2 THEN\nTYPE "b"\nELSEIF n == 3 THEN\nTYPE "c"\nELSE\nTYPE "d"\nEND'
    )
    assert said(f"n = {n}\n{branches}") == typed


def test_arguments_are_references_and_values() -> None:
    source = """
.PROGRAM main()
  a = 1
  v[2] = 5
  SET p = TRANS(1)
  CALL change(a, v[2], v[], (a), $s, p)
  TYPE a, " ", v[2], " ", v[7], " ", $s, " ", DX(p)
.END
.PROGRAM change(x, y, w[], z, $t, q)
  x = x + 10
  y = y + 10
  w[7] = 3
  z = z + 100
  $t = "set"
  SET q = q:TRANS(1)
.END
"""
    assert said(source) == ["11 15 3 set 2"]


def test_auto_is_fresh_local_is_kept_and_recursion_works() -> None:
    source = """
.PROGRAM main()
  first = TRUE
  CALL fact(5, r)
  TYPE r
  CALL counted
  CALL counted
  n = 7
  CALL counted
  TYPE n
.END
.PROGRAM fact(n, result)
  AUTO rest
  IF n < 2 THEN
    result = 1
    RETURN
  END
  CALL fact((n - 1), rest)
  result = n * rest
.END
.PROGRAM counted()
  LOCAL n
  AUTO k
  k = 1
  IF first THEN
    n = 0
    first = FALSE
  END
  n = n + k
  TYPE n
.END
"""
    assert said(source) == ["120", "1", "2", "3", "7"]


def test_names_and_words_do_not_depend_on_the_case_of_letters() -> None:
    assert said("Abc = 2\nif aBC == 2 then\nType ABC\nend") == ["2"]


def test_random_is_seeded() -> None:
    first = said("FOR i = 1 TO 5\nTYPE RANDOM\nEND")
    assert first == said("FOR i = 1 TO 5\nTYPE RANDOM\nEND")
    assert len(set(first)) == 5
    assert all(0 <= float(x) < 1 for x in first)


def test_type_formats() -> None:
    assert said('TYPE /F0.1, -0.01, /D, " ", -0.0 * 1, " ", -0.5') == ["0.0 0 -0.5"]
    assert said('TYPE /F8.2, 3.14159, /I4, 7.6, /D, 0.5, /X2, "|", /E0.2, 1234') == ["    3.14   80.5  |1.23e+03"]
    assert said('TYPE "a", /S\nTYPE "b"\nTYPE\nTYPE "c", /C, "d"') == ["ab", "", "c\nd"]
    assert said('$s = $ENCODE("x = ", /F0.1, 2.25) + $CHR(33)\nTYPE $MID($s, 1, 3), $s') == ["x =x = 2.2!"]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("x = 1 / 0", "division by zero"),
        ("x = 1 MOD 0", "division by zero"),
        ("x = SQRT(-1)", "SQRT of a negative number: -1"),
        ("x = 1E300 * 1E300", "too large"),
        ("x = (-8) ^ 0.5", "is no number"),
        ("x[1] = 0\ny = x[2]", "'x\\[2\\]' has no value yet"),
        ("x[-1] = 0", "index -1 of 'x' is out of range"),
        ("x[0.5] = 0", "index 0.5"),
        ("x[40000] = 0", "0 to 32767"),
        ("IF FALSE THEN\nx = 1\nEND\ny = x", "'x' has no value yet"),
        ("FOR i = 1 TO 2 STEP 0\nEND", "STEP of 0"),
        ("x = 1.5 BAND 1", "whole numbers of 32 bits"),
        ('$a = "x"\nFOR i = 1 TO 20\n$a = $a + $a\nEND', "the longest is 1024"),
        ("MOVE TRANS(1E7)", "TRANS: 10000000 is out of range; mm and degrees go up to 1e6"),
        ("SET p = TRANS(1)\nWHILE TRUE DO\nSET p = p:p\nEND", "1048576 is out of range"),
        ("CALL main", "more than 100 deep"),
        ("x = TIMER(1)", "timer 1 was never started"),
        ("$a = $CHR(200)", "from 0 to 127"),
        ("GOTO in\nFOR i = 1 TO 2\nin: x = 1\nEND\nFOR i = 1 TO 2\nEND", "'i' has no value|GOTO"),
    ],
)
def test_run_time_fault(source: str, message: str) -> None:
    with pytest.raises(ProgramFault, match=message):
        run(source)


def test_fault_names_line_source_and_calls() -> None:
    source = ".PROGRAM main()\n  z = 0\n  CALL inner\n.END\n.PROGRAM inner()\n  x = 1 / z\n.END\n"
    with pytest.raises(ProgramFault) as caught:
        run(compile_program(source, "job.arps"))
    assert str(caught.value) == "job.arps:6: division by zero: 1 / 0\n  6 |   x = 1 / z\n  called from line 3"


def test_program_cannot_reach_python() -> None:
    with pytest.raises(ProgramError, match="no function '__import__'"):
        compile_program('.PROGRAM m()\nx = __import__("os")\n.END')
    assert said("$s = \"__import__('os').getcwd()\"\nTYPE $s, VAL($s)") == ["__import__('os').getcwd()0"]


def test_vision_features_come_in_the_units_of_the_language() -> None:
    part = Part("coin", poses.transformation((1, 2, 3, 0, 180, 0)), (1.0, 0.4, -0.1, math.pi / 2, 3e-4, 0.02))
    machine = FakeMachine(parts=[Part("nut", np.eye(4), (1.0,)), part])
    source = """
VPICTURE
VLOCATE "coin", c
TYPE VPARTS, " ", VFEATURE(1)
FOR i = 2 TO 6
  TYPE /F0.3, VFEATURE(i)
END
TYPE DX(c)
VLOCATE "", c
TYPE VFEATURE(1), DX(c)
"""
    assert said(source, machine) == ["2 -1", "400.000", "-100.000", "90.000", "300.000", "20.000", "1", "01"]


def test_feature_without_a_part() -> None:
    with pytest.raises(ProgramFault, match=r"VFEATURE: no part was located"):
        run("x = VFEATURE(6)")


def test_a_first_value_is_given_once_to_local_and_each_time_to_auto() -> None:
    source = """.PROGRAM m()
CALL c()
CALL c()
.END
.PROGRAM c()
LOCAL n = 10, $s = "x", p = TRANS(1, 2), #q = #PPOINT(1, 2, 3, 4, 5, 6)
AUTO k = n
n = n + 1
k = k + 100
$s = $s + "y"
SET p = SHIFT(p BY 1)
MOVE #q
TYPE n, " ", k, " ", $s, " ", DX(p), " ", DY(p)
.END
"""
    assert said(source) == ["11 110 xy 2 2", "12 111 xyy 3 2"]
    with pytest.raises(ProgramError, match=r"a\[\] is a whole array"):
        said("LOCAL a[] = 1")
    with pytest.raises(ProgramError, match="expected a string, got a number"):
        said("LOCAL $a = 1")


def test_defined() -> None:
    source = """TYPE DEFINED(n), DEFINED($s), DEFINED(#p), DEFINED(a[3]), DEFINED(a[])
n = 0
$s = ""
a[3] = 1
SET p = NULL
TYPE DEFINED(n), DEFINED($s), DEFINED(a[2]), DEFINED(a[3]), DEFINED(a[]), DEFINED(p)
"""
    assert said(source) == ["00000", "-1-10-1-1-1"]
    with pytest.raises(ProgramError, match="expected the name of a variable"):
        said("TYPE DEFINED(1 + 1)")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("123456789", "123456789"),
        ("2 ^ 53", "9007199254740992"),
        ("-1234567", "-1234567"),
        ("1E20", "1e+20"),
        ("123456.789", "123456.789"),
        ("1/3", "0.333333"),
        ("0.1 + 0.2", "0.3"),
        ("-0.0 * 1", "0"),
        ("0.000012345678", "1.23457e-05"),
    ],
)
def test_numbers_in_the_free_format_keep_their_digits(value: str, text: str) -> None:
    assert said(f"TYPE {value}") == [text]


def test_a_deep_chain_of_calls_shows_its_ends() -> None:
    """Two programs that call each other 100 deep: both ends, and how many calls are between."""
    with pytest.raises(ProgramFault) as caught:
        said(".PROGRAM a()\nx = 1\nCALL b()\n.END\n.PROGRAM b()\nCALL a()\n.END")
    lines = str(caught.value).splitlines()
    calls = [line.strip() for line in lines if "call" in line and "|" not in line][1:]
    assert calls[4] == "... 91 more calls ..."
    assert len(calls) == 9
    assert calls[-2:] == ["called from line 6", "called from line 3"]
