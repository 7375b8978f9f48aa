"""Constants of a model as C source: every array and struct that a jo_model points to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.model.native.library import ffi
from jousto.model.native.native import Engine

A_ROW = 4  # number of values in a line
TUNABLE = ("force", "friction", "signal")  # structs whose data can change during a run


@dataclass(frozen=True, eq=False)
class Constants:
    """Constants of a model in C.

    Attributes
    ----------
    text : str
        Definitions, all static, the last one ``static const jo_model model``.
    tunable : (n,) array
        Values that the program can change: gravity, data of forces, frictions and signals; in C
        ``tunable``.
    places : dict
        First index of each object in `tunable`, by struct and index; gravity is
        ``("gravity", 0)``.
    fixed : str
        Definitions without `tunable`.
    """

    text: str
    tunable: NDArray[np.float64]
    places: dict[tuple[str, int], int]
    fixed: str = ""

    @property
    def bytes(self) -> int:
        """Length of the text, bytes."""
        return len(self.text)


def constants(engine: Engine, more: Sequence[float] = ()) -> Constants:
    """Return the constants of a model in C, from the structs of an engine.

    Parameters
    ----------
    engine : Engine
        Engine of the model.
    more : sequence of float
        Further tunable values after those of the engine, at ``("named", 0)``.
    """
    return _Writer(engine, list(more)).written()


def number(x: float) -> str:
    """Return a double in C, exact to the last bit.

    Examples
    --------
    >>> number(0.1), number(-2.0), number(float("inf"))
    ('0x1.999999999999ap-4', '-2.0', 'INFINITY')
    """
    x = float(x)
    if math.isnan(x):
        return "NAN"
    if math.isinf(x):
        return "INFINITY" if x > 0 else "-INFINITY"
    if x == int(x) and abs(x) < 1e9:
        return "-0.0" if x == 0.0 and math.copysign(1.0, x) < 0 else f"{int(x)}.0"
    return x.hex()


def array(name: str, values: NDArray[np.float64], *, kind: str = "double") -> str:
    """Return the definition of a constant array."""
    flat = [number(x) if kind == "double" else str(int(x)) for x in np.ravel(values)]
    width = A_ROW if kind == "double" else 16
    lines = [", ".join(flat[i : i + width]) for i in range(0, len(flat), width)]
    body = ",\n    ".join(lines)
    # double becomes complex in the build for derivatives
    kind = {"double": "jo_real"}.get(kind, kind)
    return f"static const {kind} {name}[{len(flat)}] = {{\n    {body}\n}};\n"


def text(value: str) -> str:
    r"""Return a string literal in C.

    Examples
    --------
    >>> print(text('a "b"'))
    "a \"b\""
    """
    out = []
    for byte in value.encode():
        char = chr(byte)
        if char in '"\\':
            out.append("\\" + char)
        elif 32 <= byte < 127 and char != "?":  # no trigraphs
            out.append(char)
        else:
            out.append(f"\\{byte:03o}")
    return '"' + "".join(out) + '"'


@dataclass(eq=False)
class _Writer:
    engine: Engine
    more: list[float]
    pieces: list[str] = field(default_factory=list)
    known: dict[int, str] = field(default_factory=dict)
    tunable: list[float] = field(default_factory=list)
    places: dict[tuple[str, int], int] = field(default_factory=dict)

    def written(self) -> Constants:
        self.ffi = ffi()
        native = self.engine.native_model
        tuned = self._tuned(native)
        fields = []
        for name, about in self.ffi.typeof("jo_model").fields:
            value = getattr(native, name)
            if about.type.kind != "pointer":
                fields.append((name, self._plain(value)))
            elif name == "gravity":
                fields.append((name, "tunable"))
            elif name in tuned:
                fields.append((name, tuned[name]))
            else:
                fields.append((name, self._array(name, about.type.item, value)))
        body = ",\n".join(f"    .{name} = {value}" for name, value in fields)
        self.pieces.append(f"static const jo_model model = {{\n{body}\n}};\n")
        self.places |= {("named", k): len(self.tunable) + k for k in range(len(self.more))}
        tunable = np.array(self.tunable + self.more)
        first, fixed = array("tunable", tunable), "\n".join(self.pieces)
        return Constants(f"{first}\n{fixed}", tunable, self.places, fixed)

    def _tuned(self, native: Any) -> dict[str, str]:
        """Collect the tunable values; then write the structs that point to them."""
        gravity = [float(native.gravity[k]) for k in range(3)]
        self.places["gravity", 0] = 0
        self.tunable += gravity
        made = {}
        for kind in TUNABLE:
            structs = getattr(native, kind)
            count = self.engine.count(structs)
            pointers = []
            for i in range(count):
                if structs[i].data == self.ffi.NULL:
                    pointers.append("0")
                    continue
                at = len(self.tunable)
                self.places[kind, i] = at
                self.tunable += self._behind(structs[i].data).tolist()
                cast = "(const jo_friction_data *)" if kind == "friction" else ""
                pointers.append(f"{cast}(tunable + {at})")
            made[kind] = self._structs(kind, f"jo_{kind}", structs, count, {"data": pointers})
        return made

    def _array(self, name: str, item: Any, pointer: Any) -> str:
        """Append the definition of an array of numbers or structs; return its name."""
        if pointer == self.ffi.NULL:
            return "0"
        if item.kind == "primitive":
            return self._numbers(name, item, pointer)
        return self._structs(name, item.cname, pointer, self.engine.count(pointer), {})

    def _structs(
        self, name: str, kind: str, structs: Any, count: int, given: dict[str, Sequence[str]]
    ) -> str:
        if count == 0:
            return "0"
        rows = []
        for i in range(count):
            struct, values = structs[i], []
            for key, about in self.ffi.typeof(kind).fields:
                if key in given:
                    values.append(f".{key} = {given[key][i]}")
                    continue
                value = getattr(struct, key)
                if about.type.cname.startswith("int(*)"):  # functions of a user, not supported
                    continue
                if about.type.kind == "pointer":
                    if about.type.item.kind == "void" or value == self.ffi.NULL:
                        continue
                    pointed = self._numbers(f"{name}_{i}_{key}", about.type.item, value)
                    cast = (
                        ""
                        if about.type.item.kind == "primitive"
                        else f"(const {about.type.item.cname} *)"
                    )
                    values.append(f".{key} = {cast}{pointed}")
                else:
                    values.append(f".{key} = {self._plain(value)}")
            rows.append("    {" + ", ".join(values) + "}")
        self.pieces.append(
            f"static const {kind} {name}[{count}] = {{\n" + ",\n".join(rows) + "\n};\n"
        )
        return name

    def _numbers(self, name: str, item: Any, pointer: Any) -> str:
        """Append the array behind a pointer, once; return its name."""
        address = int(self.ffi.cast("uintptr_t", pointer))
        kind = "int" if item.cname == "int" else "double"
        values = self._behind(pointer, kind)
        if values.size == 0:
            return "0"
        if address not in self.known:
            self.pieces.append(array(name, values, kind=kind))
            self.known[address] = name
        return self.known[address]

    def _behind(self, pointer: Any, kind: str = "double") -> NDArray[Any]:
        """Return the numbers behind a pointer to numbers or to a struct of numbers."""
        count = self.engine.count(pointer)
        data = self.ffi.buffer(self.ffi.cast("char *", pointer), self.ffi.sizeof(kind) * count)
        return np.frombuffer(data, np.intc if kind == "int" else np.float64, count)

    def _plain(self, value: Any) -> str:
        if isinstance(value, bool | int):
            return str(int(value))
        if isinstance(value, float):
            return number(value)
        kind = self.ffi.typeof(value)
        if kind.kind == "array":
            return "{" + ", ".join(self._plain(x) for x in value) + "}"
        raise AssertionError(f"{kind}")
