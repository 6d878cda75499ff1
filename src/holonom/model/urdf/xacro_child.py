"""The process that expands one xacro file. Run as a script: a request as JSON comes in, the URDF as JSON goes out.

xacro evaluates Python expressions and reads files that a robot description names. Here it works behind two fences:
expressions may not reach for what starts with an underscore (nor for frames and code), and an audit hook refuses
every event that expanding XML does not need, above all opening files outside the given folders and writing any. The
environment is empty. Imports nothing of Holonom.
"""

from __future__ import annotations

import ast
import glob  # noqa: F401  (loaded before the fence stands)
import json
import os
import re
import signal
import sys
import types
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar
from xml.dom import expatbuilder, minidom
from xml.parsers import expat

import xacro  # type: ignore[import-untyped]
import xacro.substitution_args  # type: ignore[import-untyped]
import yaml  # type: ignore[import-untyped]  # noqa: F401  (loaded before the fence stands)

__all__: list[str] = []

MEMORY = 2**30
SECONDS = 30
"""Of the processor."""
LARGEST_FILE = 16 * 2**20
DIGITS = 400
"""Digits of a whole number: a double has 309 before its point."""
LONGEST = 1_000_000
"""Elements of a range, characters of a text."""
EXPRESSION_SECONDS = 1.0
"""Of the processor, for one expression."""
NOTE = 4096
"""First bytes of the error stream (a file): place and text of the expression that is being evaluated, as JSON."""
HARMLESS = {
    "builtins.id",
    "code.__new__",
    "compile",
    "exec",
    "glob.glob",
    "glob.glob/2",
    "object.__getattr__",
    "sys._getframe",
    "sys.excepthook",
}
FRAMES = re.compile(r"_|(gi|ag|cr|tb|f|co)_|mro$|format$|format_map$")
"""Attributes that lead from an expression into the interpreter."""


class Refused(Exception):
    """Something that a xacro file may not do."""


class Located(Exception):
    """A problem at a known place."""

    def __init__(self, message: str, file: str, line: int) -> None:
        super().__init__(message)
        self.file, self.line = file, line


def _raise_fence(folders: Sequence[str]) -> None:
    """Refuse every audited event but harmless ones and reading inside the folders. It stands until the process ends."""
    inside = tuple(os.path.join(folder, "") for folder in folders)
    allowed = ", ".join(folders)

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event in HARMLESS:
            return
        if event in ("open", "os.listdir", "os.scandir") and isinstance(arguments[0], str | bytes):
            path = os.path.realpath(os.fsdecode(arguments[0]))
            writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC)
            if not writes and (path + os.sep).startswith(inside):
                return
            raise Refused(
                f"reading {path} is refused: a xacro file may read in {allowed} only; "
                "copy the file there, or name its folder in packages="
            )
        raise Refused(f"{event} is refused: a xacro file may compute and read files of its folder, nothing else")

    sys.addaudithook(hook)


def _limit_means() -> None:
    try:
        import resource
    except ImportError:  # not on this system
        return
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))


def _checked_eval(expression: str, symbols: dict[str, Any], local: Mapping[str, Any] | None = None) -> Any:
    """xacro's own evaluation, after a look at every name in the expression, nested ones too."""
    tree = ast.parse(expression.strip(), mode="eval")
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and FRAMES.match(node.attr):
            raise Refused(f"attribute {node.attr!r} in an expression is refused")
        if isinstance(node, ast.Name) and node.id.startswith("__"):
            raise Refused(f"name {node.id!r} in an expression is refused")
    bounded = ast.fix_missing_locations(_Bounded().visit(tree))
    symbols.update(__builtins__={}, __power=_power, __times=_times, __shifted=_shifted)
    if "range" in symbols:
        symbols["range"] = _range
    compiled = compile(bounded, "<expression>", "eval")
    if any(isinstance(node, _Bounded.CALLS) for node in ast.walk(tree)):
        with _Watch(expression):
            value = eval(compiled, symbols, local)
    else:
        value = eval(compiled, symbols, local)
    if isinstance(value, str | bytes | list | tuple | dict | set) and len(value) > LONGEST:
        raise Refused(f"${{{_cut(expression)}}} has {len(value)} elements; {LONGEST} at most")
    return value


class _Watch:
    """Ends the process when one expression takes longer than it may; the note tells which one that was.

    A library function written in C cannot be interrupted otherwise: no Python handler runs before it returns.
    """

    waiting: ClassVar[list[bytes]] = []

    def __init__(self, expression: str) -> None:
        file, line = _place_of(sys._getframe(2))
        note = json.dumps({"file": file, "line": line, "expression": _cut(expression)}).encode()
        self.note = note[:NOTE].ljust(NOTE)

    def __enter__(self) -> None:
        self.waiting.append(self.note)
        self._start()

    def __exit__(self, *_: object) -> None:
        self.waiting.pop()
        self._start()

    def _start(self) -> None:
        if not hasattr(signal, "setitimer"):  # not on this system
            return
        if self.waiting:
            os.pwrite(2, self.waiting[-1], 0)
        signal.setitimer(signal.ITIMER_PROF, EXPRESSION_SECONDS if self.waiting else 0.0)


def _cut(expression: str) -> str:
    return expression if len(expression) <= 80 else f"{expression[:77]}..."


def _place_of(frame: types.FrameType | None) -> tuple[str, int]:
    """File and line of the innermost element that the calling frames work on."""
    while frame is not None:
        values = frame.f_locals
        for name in ("node", "elt", "tag"):
            ask = getattr(values.get(name), "getUserData", None)
            if ask and (place := ask("origin")):
                return str(place[0]), int(place[1])
        frame = frame.f_back
    return "", 1


class _Bounded(ast.NodeTransformer):
    """Puts what can grow without bound through a function that looks before it computes."""

    CALLS = (ast.Call, ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp, ast.Mod, ast.JoinedStr)
    """What may take long in one step."""
    GROWS = {ast.Pow: "__power", ast.Mult: "__times", ast.LShift: "__shifted"}

    def visit_BinOp(self, node: ast.BinOp) -> Any:
        self.generic_visit(node)
        name = self.GROWS.get(type(node.op))
        if name is None:
            return node
        call = ast.Call(ast.Name(name, ast.Load()), [node.left, node.right], [])
        return ast.copy_location(call, node)


def _power(a: Any, b: Any) -> Any:
    if isinstance(a, int) and isinstance(b, int) and abs(a) > 1 and abs(a).bit_length() * b > 4 * DIGITS:
        raise Refused(f"{_short(a)} ** {_short(b)} has more than {DIGITS} digits; no measure of a robot has")
    return a**b


def _shifted(a: Any, b: Any) -> Any:
    if isinstance(b, int) and b > 4 * DIGITS:
        raise Refused(f"{_short(a)} << {_short(b)} has more than {DIGITS} digits; no measure of a robot has")
    return a << b


def _times(a: Any, b: Any) -> Any:
    for text, count in ((a, b), (b, a)):
        if isinstance(text, str | list | tuple | bytes) and isinstance(count, int) and len(text) * count > LONGEST:
            raise Refused(f"{len(text)} elements {_short(count)} times are more than {LONGEST}")
    return a * b


def _range(*limits: Any) -> range:
    found = range(*limits)
    if found and abs(found[-1] - found[0]) > LONGEST * abs(found.step):
        raise Refused(f"a range of more than {LONGEST} elements")
    return found


def _short(number: Any) -> str:
    """A number in few characters; of a long one how long it is."""
    if isinstance(number, int) and number.bit_length() > 64:
        return f"(a number of {number.bit_length()} bits)"
    return repr(number)[:40]


def _no_eval(expression: str, context: object) -> str:
    raise Refused(f"$(eval {expression}) is refused; write ${{{expression}}}")


def _no_environment(resolved: str, command: str, arguments: Sequence[str], context: object) -> str:
    raise Refused(
        f"$({command}) is refused: the environment is not read; pass a value in arguments= and use $(arg ...)"
    )


class _Builder(expatbuilder.ExpatBuilder):
    """minidom's own builder; elements remember file and line, document types are refused."""

    def __init__(self, file: str) -> None:
        super().__init__()
        self.file = file

    def start_doctype_decl_handler(self, *_: object) -> None:
        raise Located("a document type (<!DOCTYPE ...>) is not accepted; delete it", self.file, self._line())

    def start_element_handler(self, name: str, attributes: Any) -> None:
        super().start_element_handler(name, attributes)
        self.curNode.setUserData("origin", (self.file, self._line()), _Copied)

    def _line(self) -> int:
        return int(self.getParser().CurrentLineNumber)


class _Copied:
    """Passes an element's origin on to its copies: the handler that `setUserData` asks for."""

    @staticmethod
    def handle(operation: int, key: str, origin: tuple[str, int], source: Any, copy: Any) -> None:
        if copy is not None:
            copy.setUserData(key, origin, _Copied)


def _parse(_: object, file: str) -> Any:
    """Take the place of `xacro.parse`, which keeps no line numbers."""
    try:
        with open(file, "rb") as opened:
            content = opened.read(LARGEST_FILE + 1)
        if len(content) > LARGEST_FILE:
            raise Located(f"more than {LARGEST_FILE >> 20} MiB; split the file", file, 1)
        return _Builder(file).parseString(content)
    except expat.ExpatError as error:
        problem = f"not well-formed XML ({expat.ErrorString(error.code)}), column {error.offset + 1}"
        raise Located(problem, file, error.lineno) from None
    except OSError as error:
        xacro.filestack.pop()
        raise xacro.XacroException(f"{error.strerror}: {file}", exc=error) from None


def _expand(request: dict[str, Any]) -> dict[str, Any]:
    packages = request["packages"]

    def share_directory(name: str) -> str:
        if name not in packages:
            known = ", ".join(sorted(packages)) or "none"
            raise Refused(f"$(find {name}): no such package; packages= names {known}. Add its folder there")
        return str(packages[name])

    finder = types.ModuleType("ament_index_python.packages")
    finder.get_package_share_directory = share_directory  # type: ignore[attr-defined]
    sys.modules["ament_index_python"] = types.ModuleType("ament_index_python")
    sys.modules[finder.__name__] = finder
    xacro.parse, xacro.safe_eval = _parse, _checked_eval
    xacro.substitution_args._eval = _no_eval
    xacro.substitution_args._env = xacro.substitution_args._optenv = _no_environment
    _limit_means()
    _raise_fence([os.path.dirname(request["file"]), *packages.values()])
    document = xacro.process_file(request["file"], mappings=request["arguments"], verbosity=0)
    return {"urdf": document.documentElement.toxml(), "origins": _origins(document.documentElement, request["file"])}


def _origins(root: Any, file: str) -> list[tuple[str, int]]:
    """Origin of every element in document order; one that a macro made up has that of the element around it."""
    found = []
    waiting = [(root, (file, 1))]
    while waiting:
        element, around = waiting.pop()
        origin = element.getUserData("origin") or around
        found.append(origin)
        inner = [(child, origin) for child in element.childNodes if child.nodeType == minidom.Node.ELEMENT_NODE]
        waiting += reversed(inner)
    return found


def _cause(error: BaseException) -> BaseException:
    """What xacro's own exceptions are wrapped around."""
    while (inner := getattr(error, "exc", None)) is not None:
        error = inner
    return error


def _place(error: BaseException, file: str) -> tuple[str, int]:
    """File and line of the innermost element that was worked on."""
    place = (file, 1)
    trace = error.__traceback__
    while trace is not None:
        values = trace.tb_frame.f_locals
        for name in ("node", "elt", "tag"):
            ask = getattr(values.get(name), "getUserData", None)
            place = (ask and ask("origin")) or place
        trace = trace.tb_next
    return place


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    try:
        return _expand(request)
    except Located as error:
        return {"error": str(error), "file": error.file, "line": error.line}
    except Exception as error:  # whatever a xacro file brings about is an error of that file
        file, line = _place(error, request["file"])
        return {"error": _message(error), "file": file, "line": line}


def _message(error: BaseException) -> str:
    cause = _cause(error)
    if isinstance(cause, MemoryError):
        return f"more than {MEMORY >> 20} MiB are needed to expand it"
    if isinstance(cause, OSError):
        return f"{cause.filename}: {cause.strerror}"
    message = str(cause if isinstance(cause, Refused) else error)
    return " ".join(message.split()) or type(error).__name__


if __name__ == "__main__":
    os.lseek(2, NOTE, os.SEEK_SET)
    print(json.dumps(_answer(json.load(sys.stdin))))
