"""Line numbers of keys: every path that `tomllib` reads is found, on the line where its name stands."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from holonom.app.fields.toml_lines import KeyPath, key_lines

NASTY = '''# [no] = "table"
top = 1.5e3  # = [ { "
"quoted key" = "a # b \\" ] }"
'literal.key' = 'c:\\'
when = 1979-05-27 07:32:00Z
a.b.c = [1, [2, 3], # in between ]
  { x = 1, y.z = "}" },
]
text = """
[not.a.table]
key = "no""""
literal = \'\'\'
x = 1\'\'\'
"caf\\u00e9" = {}

[[list]]
k = 1
[list.sub]
deep = true
[[list.inner]]
[[list.inner]]
here = 4
[[list]]
k = 2
[ other . "dotted.name" ]
k = -inf
'''


def paths(value: Any, at: KeyPath = ()) -> Iterator[KeyPath]:
    """Every key and element of a document."""
    if at:
        yield at
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield from paths(inner, (*at, key))


def test_finds_every_path_of_a_nasty_text() -> None:
    lines = key_lines(NASTY)
    assert set(lines) == set(paths(tomllib.loads(NASTY)))


def test_lines_of_a_nasty_text() -> None:
    lines = key_lines(NASTY)
    rows = NASTY.splitlines()
    for path, word in {
        ("top",): "top",
        ("quoted key",): '"quoted key"',
        ("a", "b", "c", 2): "{ x",
        ("a", "b", "c", 2, "y", "z"): "y.z",
        ("literal",): "literal",
        ("café",): "caf",
        ("list", 0, "sub", "deep"): "deep",
        ("list", 0, "inner", 1, "here"): "here",
        ("other", "dotted.name", "k"): "k = -inf",
    }.items():
        assert word in rows[lines[path] - 1], path
    assert lines["list", 1, "k"] == lines["list", 1] + 1 == rows.index("k = 2") + 1


def test_empty_text_and_windows_line_ends() -> None:
    assert key_lines("") == {}
    assert key_lines("\r\n[a]\r\nb = 1\r\n") == {("a",): 2, ("a", "b"): 3}


names = st.text(min_size=1, max_size=5)
scalars = st.integers() | st.booleans() | st.text(max_size=20)
values = st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3))


def written(value: Any, gap: str) -> str:
    """A value as TOML; `gap` stands between the elements of arrays."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(c):08x}" for c in value) + '"'
    if isinstance(value, list):
        return "[" + ",".join(gap + written(inner, gap) for inner in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{written(k, '')} = {written(v, '')}" for k, v in value.items()) + "}"
    return str(value)


@given(st.lists(st.dictionaries(names, values, max_size=3), max_size=4), st.sampled_from([" ", "\n", " # ]\n\n "]))
def test_finds_every_path_of_any_text(tables: list[dict[str, Any]], gap: str) -> None:
    text, expected = "", {}
    for number, table in enumerate(tables):
        text += "[[t]]\n"
        for key, value in table.items():
            expected["t", number, key] = text.count("\n") + 1
            text += f"{written(key, '')} = {written(value, gap)}\n"
    lines = key_lines(text)
    assert set(lines) == set(paths(tomllib.loads(text)))
    assert expected.items() <= lines.items()
