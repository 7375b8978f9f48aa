"""Programs of the engine: expressions as a list of operations, with their derivatives.

Equal operations are stored once. Derivatives follow by the chain rule, backwards from each result
(Griewank and Walther, Evaluating Derivatives, 2008, chapter 6), as further operations of the list.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

Of: TypeAlias = tuple[int, ...] | int | float | complex
"""Operands of an operation, index of a leaf, or a number."""
BLOCK = "numbers"
"""Kind of a leaf of several numbers: a table."""
LEAVES = ("state", "value", "rate", "time", "signal", "signal rate", "memory", "gravity")

FEW = 4
"""Most derivatives of an entry that several rows need and that is differentiated once."""

FOLDED: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "sqrt": math.sqrt,
    "exp": math.exp,
    "log": math.log,
    "sin": math.sin,
    "cos": math.cos,
    "atan": math.atan,
    "tanh": math.tanh,
    "power": lambda a, b: a**b,
    "minimum": min,
    "maximum": max,
    "select": lambda a, b, c: b if a > 0 else c,
    "edge": lambda a, b: a / (a * a + b * b) ** 0.25,
}
"""The operations of the engine (``jo_do``) on numbers."""


@dataclass(eq=False)
class Program:
    """List of operations; each entry is a number, a leaf, or an operation on earlier entries."""

    nodes: list[tuple[str, Of]] = field(default_factory=list)
    tables: list[tuple[float | complex, ...]] = field(default_factory=list)
    _known: dict[tuple[str, Of], int] = field(default_factory=dict)
    _tables: dict[tuple[float | complex, ...], int] = field(default_factory=dict)

    def _node(self, kind: str, of: Of) -> int:
        key = (kind, of)
        if key not in self._known:
            self._known[key] = len(self.nodes)
            self.nodes.append(key)
        return self._known[key]

    def number(self, x: float | complex) -> int:
        """Return the entry of a number; complex ones are numbers with a derivative."""
        return self._node("number", x + 0.0)

    def leaf(self, kind: str, index: int = 0) -> int:
        """Return the entry of a state, value, rate, signal with an index, or of time."""
        return self._node(kind, index)

    def numbers(self, x: tuple[float | complex, ...]) -> int:
        """Return the entry of the numbers of a table."""
        if x not in self._tables:
            self._tables[x] = len(self.tables)
            self.tables.append(x)
        return self._node(BLOCK, self._tables[x])

    def _value(self, node: int) -> float | None:
        kind, of = self.nodes[node]
        return of if kind == "number" and isinstance(of, float) else None

    def add(self, operation: str, *parts: int) -> int:
        """Return the entry of an operation; operations on numbers are carried out."""
        values = [self._value(part) for part in parts]
        if all(x is not None for x in values):
            try:
                return self.number(FOLDED[operation](*values))
            except (ValueError, ZeroDivisionError, OverflowError):
                return self.number(math.nan)
        kept = self._simple(operation, parts, values)
        return self._node(operation, parts) if kept is None else kept

    def _simple(
        self, operation: str, parts: tuple[int, ...], values: Sequence[float | None]
    ) -> int | None:
        """Return the operand that an operation with 0 or 1 leaves, or None."""
        a, b = (*values, None)[:2]
        if operation == "add":
            return parts[1] if a == 0.0 else parts[0] if b == 0.0 else None
        if operation == "subtract":
            return parts[0] if b == 0.0 else None
        if operation == "multiply":
            if a == 0.0 or b == 0.0:
                return self.number(0.0)
            if a == 1.0 or b == 1.0:
                return parts[1] if a == 1.0 else parts[0]
            return self._switched(*parts)
        if operation == "divide":
            return self.number(0.0) if a == 0.0 else parts[0] if b == 1.0 else None
        if operation == "power":
            if b == 1.0:
                return parts[0]
            return self.add("multiply", parts[0], parts[0]) if b == 2.0 else None
        if operation == "select" and parts[1] == parts[2]:
            return parts[1]
        return None

    def _switched(self, factor: int, switch: int) -> int | None:
        """Return a factor that is switched on or off: times a selection of 1 or 0; else None."""
        kind, of = self.nodes[switch]
        if kind != "select" or not isinstance(of, tuple):
            return None
        one, none = (self._value(part) for part in of[1:])
        if (one, none) == (1.0, 0.0):
            return self.add("select", of[0], factor, of[2])
        return self.add("select", of[0], of[1], factor) if (one, none) == (0.0, 1.0) else None

    def _edge_curvature(self, a: int, b: int) -> int:
        """Return the second derivative of an edge, ``-(a^2/4 + 3 b^2/2) g/(a^2 + b^2)^2``."""
        s, t = self.add("multiply", a, a), self.add("multiply", b, b)
        own = self.add("multiply", self.number(-0.25), s)
        other = self.add("multiply", self.number(-1.5), t)
        both = self.add("add", s, t)
        top = self.add("multiply", self.add("add", own, other), self.add("edge", a, b))
        return self.add("divide", top, self.add("multiply", both, both))

    def _partial(self, node: int, parts: tuple[int, ...]) -> tuple[int, ...]:
        """Return the derivatives of an operation with respect to its operands."""
        one, none = self.number(1.0), self.number(0.0)
        a, b, c = (*parts, none, none)[:3]
        match self.nodes[node][0]:
            case "add":
                return one, one
            case "subtract":
                return one, self.number(-1.0)
            case "multiply":
                return b, a
            case "divide":
                inverse = self.add("divide", one, b)
                return inverse, self.add("subtract", none, self.add("multiply", node, inverse))
            case "sqrt":
                return (self.add("divide", self.number(0.5), node),)
            case "exp":
                return (node,)
            case "log":
                return (self.add("divide", one, a),)
            case "sin":
                return (self.add("cos", a),)
            case "cos":
                return (self.add("subtract", none, self.add("sin", a)),)
            case "atan":
                square = self.add("multiply", a, a)
                return (self.add("divide", one, self.add("add", one, square)),)
            case "tanh":
                return (self.add("subtract", one, self.add("multiply", node, node)),)
            case "power":
                less = self.add("power", a, self.add("subtract", b, one))
                if self._value(b) is not None:
                    return self.add("multiply", b, less), none
                return self.add("multiply", b, less), self.add("multiply", node, self.add("log", a))
            case "minimum":
                more = self.add("subtract", b, a)
                return self.add("select", more, one, none), self.add("select", more, none, one)
            case "maximum":
                more = self.add("subtract", a, b)
                return self.add("select", more, one, none), self.add("select", more, none, one)
            case "edge":
                return self.add("edge slope", a, b), none  # b, the transition, is a number
            case "edge slope":
                return self._edge_curvature(a, b), none
            case "table":
                return self.add("table x", *parts), none
            case "map":
                return self.add("map x", *parts), none, self.add("map y", *parts)
            case _:  # select
                return none, self.add("select", a, one, none), self.add("select", a, none, one)

    def derivatives(
        self, node: int, leaves: tuple[str, ...] = ("state", "value", "rate")
    ) -> dict[tuple[str, int], int]:
        """Return the derivatives of an entry with respect to states, values and rates.

        Parameters
        ----------
        node : int
            The entry.
        leaves : tuple of str
            Kinds of the leaves.

        Returns
        -------
        dict
            Entries of the derivatives that are not 0 by kind and index of the leaf.
        """
        return self._backwards(node, leaves, {})

    def jacobian(self, rows: Sequence[int]) -> list[dict[tuple[str, int], int]]:
        """Return the derivatives of some entries with respect to states, values and rates.

        What several rows need, such as a flow between two nodes, is differentiated once, and each
        row multiplies its few derivatives.
        """
        leaves = ("state", "value", "rate")
        needed = Counter(at for row in set(rows) for at in self.below([row]))
        shared = [at for at, count in needed.items() if count > 1]
        below: dict[int, dict[tuple[str, int], int]] = {}
        for at in sorted(shared):
            if isinstance(self.nodes[at][1], tuple):
                found = self._backwards(at, leaves, below)
                if len(found) <= FEW:
                    below[at] = found
        return [self._backwards(row, leaves, below) for row in rows]

    def _backwards(
        self, node: int, leaves: tuple[str, ...], known: dict[int, dict[tuple[str, int], int]]
    ) -> dict[tuple[str, int], int]:
        """Return the derivatives of an entry, with known ones of some entries below it."""
        slope = {node: self.number(1.0)}
        found: dict[tuple[str, int], int] = {}
        for at in sorted(self.below([node]), reverse=True):
            if at not in slope:
                continue
            kind, of = self.nodes[at]
            if at in known:
                for leaf, own in known[at].items():
                    more = self.add("multiply", slope[at], own)
                    found[leaf] = self.add("add", found[leaf], more) if leaf in found else more
            elif isinstance(of, tuple):
                for part, own in zip(of, self._partial(at, of), strict=False):
                    more = self.add("multiply", slope[at], own)
                    before = slope.get(part)
                    slope[part] = more if before is None else self.add("add", before, more)
            elif kind in leaves and self._value(slope[at]) != 0.0:
                assert isinstance(of, int)
                before = found.get((kind, of))
                more = slope[at]
                found[kind, of] = more if before is None else self.add("add", before, more)
        return {leaf: own for leaf, own in found.items() if self._value(own) != 0.0}

    def below(self, nodes: Iterable[int]) -> set[int]:
        """Return all entries on which some entries depend, with these."""
        seen: set[int] = set()
        stack = list(nodes)
        while stack:
            at = stack.pop()
            if at in seen:
                continue
            seen.add(at)
            of = self.nodes[at][1]
            if isinstance(of, tuple):
                stack += of
        return seen
