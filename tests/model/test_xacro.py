"""xacro files expand, say where they are wrong, and read nothing outside their folder and the given packages."""

from __future__ import annotations

import shutil
import sys
import time

import pytest

from holonom.errors import InputError, ModelError
from holonom.mechanics import load_arm

xacro = pytest.importorskip("xacro", reason="xacro is not installed; pip install -e '.[xacro]'")

HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
JOINT = (
    '<link name="a"/><link name="b"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/>'
    '<origin xyz="0 0 {z}"/></joint>'
)


@pytest.fixture
def write(tmp_path):
    """Write robot/arm.xacro, its body from line 2 on; beside the folder lies what it must not read."""
    (tmp_path / "robot").mkdir()
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "size.yaml").write_text("z: 7\n")
    (tmp_path / "outside" / "part.xacro").write_text(f"{HEAD}{JOINT.format(z=7)}</robot>")
    (tmp_path / "robot" / "link.yaml").symlink_to(tmp_path / "outside" / "size.yaml")
    (tmp_path / "robot" / "link.xacro").symlink_to(tmp_path / "outside" / "part.xacro")
    (tmp_path / "robot" / "folder").symlink_to(tmp_path / "outside")

    def write(body: str):
        file = tmp_path / "robot" / "arm.xacro"
        file.write_text(f"{HEAD}\n{body}\n</robot>")
        return file

    return write


def height(arm) -> float:
    return arm.model.joints[0].before[2][3]


def test_macros_arguments_and_files_of_the_folder(write, tmp_path):
    (tmp_path / "robot" / "size.yaml").write_text("z: 0.25\n")
    (tmp_path / "robot" / "joint.xacro").write_text(
        f'{HEAD}<xacro:macro name="joint" params="z">{JOINT.format(z="${z}")}</xacro:macro></robot>'
    )
    body = (
        '<xacro:arg name="k" default="1"/><xacro:include filename="joint.xacro"/>'
        "<xacro:joint z=\"${xacro.load_yaml('size.yaml')['z'] * float(xacro.arg('k')) + sin(0)}\"/>"
    )
    assert height(load_arm(write(body))) == 0.25
    assert height(load_arm(write(body), arguments={"k": "4"})) == 1.0
    assert height(load_arm(write('<xacro:include filename="joi*.xacro"/><xacro:joint z="2"/>'))) == 2.0


def test_given_packages_may_be_read(write, tmp_path):
    body = '<xacro:include filename="$(find parts)/part.xacro"/>'
    assert height(load_arm(write(body), packages={"parts": tmp_path / "outside"})) == 7
    with pytest.raises(ModelError, match=r"arm\.xacro, line 2: \$\(find parts\): no such package"):
        load_arm(write(body))
    with pytest.raises(ModelError, match=r"package 'parts': .* is no folder"):
        load_arm(write(body), packages={"parts": tmp_path / "absent"})


OUTSIDE = [
    '<xacro:include filename="../outside/part.xacro"/>',
    '<xacro:include filename="{tmp}/outside/part.xacro"/>',
    '<xacro:include filename="link.xacro"/>',
    '<xacro:include filename="folder/part.xacro"/>',
    '<xacro:include filename="../outside/*.xacro"/>',
    '<xacro:include filename="../outside/part.xacro" optional="true"/>',
    '<xacro:include filename="$(cwd)/../outside/part.xacro"/>',
    '<xacro:include filename="$(dirname)/../outside/part.xacro"/>',
    "<link name=\"${xacro.load_yaml('../outside/size.yaml')['z']}\"/>",
    "<link name=\"${xacro.load_yaml('{tmp}/outside/size.yaml')['z']}\"/>",
    "<link name=\"${xacro.load_yaml('link.yaml')['z']}\"/>",
    '<xacro:property name="y" value="${xacro.load_yaml(\'/etc/passwd\')}"/><link name="${y}"/>',
]


@pytest.mark.parametrize("body", OUTSIDE)
def test_nothing_outside_is_read(write, tmp_path, body):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ModelError) as caught:
        load_arm(write(body.replace("{tmp}", str(tmp_path))), packages={"empty": tmp_path / "empty"})
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'robot' / 'arm.xacro'}, line 2: "), message
    assert "refused" in message or "substitution" in message


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('<link name="$(env HOME)"/>', r"\$\(env HOME\) is refused"),
        ('<link name="$(optenv HOME x)"/>', r"\$\(optenv HOME x\) is refused"),
        ("<link name=\"$(eval open('arm.xacro').read())\"/>", r"\$\(eval .* is refused"),
        ('<link name="${().__class__}"/>', "attribute '__class__'"),
        ('<link name="${[x.__class__ for x in [1]]}"/>', "attribute '__class__'"),
        ('<link name="${(lambda: __import__)()}"/>', "name '__import__'"),
        ('<link name="${(x for x in [1]).gi_frame}"/>', "attribute 'gi_frame'"),
        ("<link name=\"${'x'.format(1)}\"/>", "attribute 'format'"),
    ],
)
def test_neither_the_environment_nor_the_interpreter_is_in_reach(write, monkeypatch, body, message):
    monkeypatch.setenv("HOME", "secret")
    with pytest.raises(ModelError, match=f"arm.xacro, line 2: .*{message}") as caught:
        load_arm(write(body))
    assert "secret" not in str(caught.value)


def test_the_fence_itself_refuses_what_an_expression_would_get_through(tmp_path):
    """Without the look at names: files, processes, the network and imports are out of reach all the same."""
    from holonom.model.urdf import xacro_child

    probe = tmp_path / "probe.py"
    probe.write_text(
        "import os, sys, socket, subprocess\n"
        f"sys.path.insert(0, {str(xacro_child.__file__).rsplit('/', 1)[0]!r})\n"
        "import xacro_child\n"
        f"xacro_child._raise_fence([{str(tmp_path)!r}])\n"
        f"open({str(probe)!r}).close()\n"
        "tries = {\n"
        f"    'write': lambda: open({str(tmp_path / 'new')!r}, 'w'),\n"
        "    'read': lambda: open('/etc/hostname'),\n"
        "    'list': lambda: os.listdir('/'),\n"
        "    'remove': lambda: os.remove(__file__),\n"
        "    'run': lambda: subprocess.run(['true']),\n"
        "    'shell': lambda: os.system('true'),\n"
        "    'net': lambda: socket.socket(),\n"
        "    'import': lambda: __import__('ctypes'),\n"
        "}\n"
        "for name, attempt in tries.items():\n"
        "    try:\n"
        "        attempt()\n"
        "    except xacro_child.Refused:\n"
        "        print(name)\n"
    )
    import subprocess

    done = subprocess.run([sys.executable, "-I", str(probe)], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["write", "read", "list", "remove", "run", "shell", "net", "import"]
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("body", "line", "message"),
    [
        ("<a>", 3, "not well-formed XML"),
        ("\n<link name='${nix}'/>", 3, "name 'nix' is not defined"),
        ("<xacro:macro name='m'>\n\n<link name='${nix}'/></xacro:macro>\n<xacro:m/>", 4, "'nix' is not defined"),
        ("<xacro:macro name='m'><xacro:m/></xacro:macro>\n<xacro:m/>", 2, "recursion"),
        ("\n\n<xacro:include filename='absent.xacro'/>", 4, "No such file"),
        ("<link name='${\"a\".ljust(10**10)}'/>", 2, "1024 MiB"),
        ("<link name='a'/>\n<xacro:if value='true'>\n<link name='a'/></xacro:if>", 4, "a second link 'a'"),
    ],
)
def test_errors_name_the_line_that_was_written(write, body, line, message):
    with pytest.raises(ModelError, match=rf"arm\.xacro, line {line}: .*{message}"):
        load_arm(write(body))


def test_document_types_are_refused_in_included_files(write, tmp_path):
    (tmp_path / "robot" / "bomb.xacro").write_text('\n<!DOCTYPE r [<!ENTITY b "c">]><robot><link name="&b;"/></robot>')
    with pytest.raises(ModelError, match=r"bomb\.xacro, line 2: a document type"):
        load_arm(write('<xacro:include filename="bomb.xacro"/>'))


def test_a_file_without_end_is_stopped(write, monkeypatch):
    monkeypatch.setattr("holonom.model.urdf.xacro_file.TIME_LIMIT", 0.5)
    with pytest.raises(ModelError, match="not expanded within"):
        load_arm(write("<link name='${[0 for i in range(10**6) for k in range(10**6) if i != i]}'/>"))


def test_missing_file_and_missing_library(tmp_path, write, monkeypatch):
    with pytest.raises(ModelError, match=r"absent\.xacro: no such file"):
        load_arm(tmp_path / "absent.xacro")
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(InputError, match=r"pip install -e '.\[xacro\]'"):
        load_arm(write(""))


def test_shipped_files(data_folder, tmp_path):
    shipped = data_folder / "robots" / "urdf" / "rtb_data"
    assert load_arm(shipped / "puma560_robot.urdf.xacro").n == 6
    (tmp_path / "urdf").mkdir()
    shutil.copy(shipped / "irb140_macro.xacro", tmp_path / "urdf")
    arm = load_arm(shipped / "irb140.xacro", packages={"abb_irb140": tmp_path})
    assert arm.limits.names == tuple(f"joint_{k}" for k in range(1, 7))


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("math.factorial(10**7)", r"\$\{math.factorial\(10\*\*7\)\} is not evaluated within a second"),
        ("'%09999999d' % 3", r"has 9999999 elements; 1000000 at most"),
        ("'a'.ljust(10**8)", r"has 100000000 elements; 1000000 at most"),
        ("'a'.ljust(10**10)", r"more than 1024 MiB are needed"),
        ("[k for k in range(3000) for j in range(3000)]", r"not evaluated within a second|has 9000000 elements"),
        ("9**9**9", r"9 \*\* 387420489 has more than 400 digits"),
        ("(10**300)**10", "has more than 400 digits"),
        ("2 ** (1 &lt;&lt; 70)", "has more than 400 digits"),
        ("1 &lt;&lt; 10**9", "has more than 400 digits"),
        ("'a' * 10**9", r"1 elements 1000000000 times are more than 1000000"),
        ("10**9 * [1]", "are more than 1000000"),
        ("len(range(10**12))", "a range of more than 1000000 elements"),
        ("'a'.ljust(10**10)", "more than 1024 MiB"),
        ("__power(2, 3)", "name '__power' in an expression is refused"),
    ],
)
def test_an_expression_without_measure_is_named_at_once(expression, said, write):
    """What it would come to is told from its operands; 9**9**9 has 369,693,100 digits."""
    begin = time.perf_counter()
    with pytest.raises(ModelError, match=rf"line \d+: .*{said}"):
        load_arm(write(f'<link name="a"><inertial><mass value="${{{expression}}}"/></inertial></link>'))
    assert time.perf_counter() - begin < 3.0  # of which the process takes its part


def test_numbers_that_robots_have_are_computed_as_before(write):
    said = "${2**0.5} ${(-2)**3} ${2 * [1, 2]} ${'ab' * 2} ${1 &lt;&lt; 4} ${[k**2 for k in range(3)]} ${2.0**1023 > 1}"
    with pytest.raises(ModelError, match=r"1.4142135623730951 -8 \[1, 2, 1, 2\] abab 16 \[0, 1, 4\] True"):
        load_arm(write(f'<link name="a"/><joint name="j" type="{said}"/>'))


def test_a_byte_order_mark_is_passed_over(write):
    path = write('<link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
                 '<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')  # fmt: skip
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_arm(path).n == 1
