"""Expression graph of a traced algorithm: hash-consed, simplified while it is built.

A `Scalar` stands for a number that is not known yet. Arithmetic on it records a node; equal expressions are the
same node
(common subexpressions), constants fold, zeros and ones vanish. `x * 0 -> 0` swallows NaN: kernels check their inputs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

__all__ = ["Condition", "Graph", "Number", "Op", "Scalar", "live_nodes"]

Op = tuple[object, ...]


@dataclass(slots=True)
class Graph:
    """Nodes in the order of their creation (so operands always come before their users)."""

    ops: list[Op] = field(default_factory=list)
    index: dict[Op, int] = field(default_factory=dict)

    def add(self, *op: object) -> int:
        """Return the number of the node `op`, made if it is new."""
        found = self.index.get(op)
        if found is None:
            found = self.index[op] = len(self.ops)
            self.ops.append(op)
        return found

    def input(self, name: str, slot: int) -> Scalar:
        """Return input number `slot` of the vector `name`."""
        return Scalar(self, self.add("in", name, slot))

    def constant(self, value: float) -> Scalar:
        """Return a constant; a NaN has no place in an equation."""
        if not math.isfinite(value):
            raise ValueError(f"constant {value} in a traced equation; constants must be finite")
        return Scalar(self, self.add("const", float(value) + 0.0))


class _Value:
    """One node of a graph, as an operand."""

    __slots__ = ("graph", "i")

    def __init__(self, graph: Graph, i: int) -> None:
        self.graph, self.i = graph, i

    @property
    def op(self) -> Op:
        return self.graph.ops[self.i]


class Condition(_Value):
    """A truth value not known yet; `select` chooses by it."""

    __slots__ = ()

    def __and__(self, other: Condition | bool) -> Condition | bool:
        if isinstance(other, Condition):
            return Condition(self.graph, self.graph.add("and", self.i, other.i))
        return self if other else False

    def __or__(self, other: Condition | bool) -> Condition | bool:
        if isinstance(other, Condition):
            return Condition(self.graph, self.graph.add("or", self.i, other.i))
        return True if other else self

    __rand__, __ror__ = __and__, __or__

    def __bool__(self) -> bool:
        raise TypeError("a traced condition has no value yet: use trace.select(condition, a, b) instead of if")


class Scalar(_Value):
    """A number not known yet."""

    __slots__ = ()

    @property
    def value(self) -> float | None:
        """The number, where this is a constant."""
        op = self.op
        return float(op[1]) if op[0] == "const" else None  # type: ignore[arg-type]

    def _other(self, x: Number) -> Scalar:
        return x if isinstance(x, Scalar) else self.graph.constant(float(x))

    def _make(self, *op: object) -> Scalar:
        return Scalar(self.graph, self.graph.add(*op))

    def _fold(self, other: Scalar, f: Callable[[float, float], float]) -> Scalar | None:
        a, b = self.value, other.value
        return None if a is None or b is None else self.graph.constant(f(a, b))

    def _operand(self, k: int) -> Scalar:
        return Scalar(self.graph, self.op[k])  # type: ignore[arg-type]

    def __add__(self, x: Number) -> Scalar:
        b = self._other(x)
        if (folded := self._fold(b, lambda p, q: p + q)) is not None:
            return folded
        if b.value == 0.0:
            return self
        if self.value == 0.0:
            return b
        if b.op[0] == "neg":
            return self - b._operand(1)
        if self.op[0] == "neg":
            return b - self._operand(1)
        return self._make("+", *sorted((self.i, b.i)))

    def __sub__(self, x: Number) -> Scalar:
        b = self._other(x)
        if (folded := self._fold(b, lambda p, q: p - q)) is not None:
            return folded
        if self.i == b.i:
            return self.graph.constant(0.0)
        if b.value == 0.0:
            return self
        if self.value == 0.0:
            return -b
        if b.op[0] == "neg":
            return self + b._operand(1)
        if self.op[0] == "neg":
            return -(self._operand(1) + b)
        return self._make("-", self.i, b.i)

    def __rsub__(self, x: float) -> Scalar:
        return self._other(x) - self

    def __neg__(self) -> Scalar:
        if (value := self.value) is not None:
            return self.graph.constant(-value)
        if self.op[0] == "neg":
            return self._operand(1)
        if self.op[0] == "-":
            return self._operand(2) - self._operand(1)
        return self._make("neg", self.i)

    def __mul__(self, x: Number) -> Scalar:
        b = self._other(x)
        if (folded := self._fold(b, lambda p, q: p * q)) is not None:
            return folded
        if b.value is not None:
            return b._scale(self)
        if self.value is not None:
            return self._scale(b)
        if self.op[0] == "neg":
            return -(self._operand(1) * b)
        if b.op[0] == "neg":
            return -(self * b._operand(1))
        return self._make("*", *sorted((self.i, b.i)))

    def _scale(self, x: Scalar) -> Scalar:
        """Return this constant times `x`, which is none."""
        c = self.value
        assert c is not None
        if c == 0.0:
            return self
        if c == 1.0:
            return x
        if c == -1.0:
            return -x
        if x.op[0] == "neg":
            return self.graph.constant(-c) * x._operand(1)
        if x.op[0] == "*" and (inner := x._operand(1).value) is not None:
            return self.graph.constant(c * inner) * x._operand(2)
        if x.op[0] == "*" and (inner := x._operand(2).value) is not None:
            return self.graph.constant(c * inner) * x._operand(1)
        return self._make("*", *sorted((self.i, x.i)))

    def __truediv__(self, x: Number) -> Scalar:
        b = self._other(x)
        if b.value is not None:
            return self * (1.0 / b.value)
        if self.value == 0.0:
            return self
        return self._make("/", self.i, b.i)

    def __pow__(self, k: int) -> Scalar:
        power = self._other(1.0)
        for _ in range(k):
            power = power * self
        return power

    def __rtruediv__(self, x: float) -> Scalar:
        return self._other(x) / self

    __radd__, __rmul__ = __add__, __mul__

    def __bool__(self) -> bool:
        raise TypeError("a traced scalar has no value yet: use trace.select(condition, a, b) instead of if")

    def __float__(self) -> float:
        if self.value is None:
            raise TypeError("a traced scalar has no value yet: use holonom.trace functions, not math or numpy")
        return self.value


Number = Scalar | float


def turning_inputs(graph: Graph, live: Iterable[int]) -> set[str]:
    """Names of the inputs that sines and cosines among some nodes are taken of.

    An input that comes through an atan2 is none of them: that angle lies within a turn, however large the input.
    """
    found: set[str] = set()
    seen: set[int] = set()
    stack = [a for i in live for a in graph.ops[i][1:] if graph.ops[i][0] in ("sin", "cos")]
    while stack:
        i = stack.pop()
        if not isinstance(i, int) or i in seen:
            continue
        seen.add(i)
        op = graph.ops[i]
        if op[0] == "in":
            found.add(str(op[1]))
        elif op[0] not in ("const", "atan2"):
            stack += op[1:]
    return found


def live_nodes(graph: Graph, outputs: Iterable[Scalar]) -> list[int]:
    """Return the nodes that the outputs depend on, operands first: what is left is dead code."""
    live: set[int] = set()
    stack = [out.i for out in outputs]
    while stack:
        i = stack.pop()
        if i in live:
            continue
        live.add(i)
        op = graph.ops[i]
        if op[0] not in ("in", "const"):
            stack += [a for a in op[1:] if isinstance(a, int)]
    return sorted(live)
