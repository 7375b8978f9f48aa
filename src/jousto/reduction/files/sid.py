"""Reader of standard input data (SID) of flexible bodies, a text format of multibody programs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import scipy.linalg

from jousto.base.arrays import Array
from jousto.base.errors import InputError, MissingFileError, Problem, Problems, count, warn
from jousto.base.files import check_input
from jousto.reduction.content import Content
from jousto.reduction.fields.invariants import EPS, Invariants, outer
from jousto.reduction.fields.stiffening import Stiffening

P = TypeVar("P", bound=Content)

HEAD = ("order", "nrow", "ncol", "nq", "nqn", "structure")
ZERO, DIAGONAL, SYMMETRIC, FULL, UNIT = range(5)
MARKS = {("part",), ("refmod",), ("new", "modal"), ("frame",)}
LARGEST = 1 << 27
"""Largest count of numbers in one matrix."""
LARGEST_FILE = 1 << 31
"""Bytes."""
SAME = 1e-6
"""Relative difference of one integral in two blocks that counts as rounding."""
NEEDED = ("mdCM", "J", "Ct", "Cr", "Me", "Gr", "Ke")
SPIN = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
"""Products ``w_a w_b`` of the columns of Oe."""

_ENTRY = re.compile(r"(m[01n])\(\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+)\s*)?\)\s*=\s*(\S+)")
_SAID = re.compile(r"(\w+)\s*(?:\(\s*\d+\s*\))?\s*=\s*(.*)")


@dataclass(eq=False)
class Block:
    """A matrix of the file, ``M0 + sum_k M1[:, :, k] q_k``."""

    name: str
    line: int
    head: dict[str, int] = field(default_factory=dict)
    M0: Array = field(default_factory=lambda: np.zeros((0, 0)))
    M1: Array | None = None

    def begin(self) -> str:
        """Allocate the matrices after the header of the block; return a problem with the header."""
        missing = [key for key in HEAD if key not in self.head]
        if missing:
            return f"lacks {', '.join(missing)}"
        rows, columns, nq = (self.head[key] for key in ("nrow", "ncol", "nq"))
        if min(rows, columns, nq) < 0 or rows * columns * max(nq, 1) > LARGEST:
            return f"has {rows} x {columns} x {nq} numbers, which is beyond any valid size"
        if not ZERO <= self.head["structure"] <= UNIT:
            return f"has structure {self.head['structure']}, must be 0 to 4"
        self.M0 = np.eye(rows, columns) * float(self.head["structure"] == UNIT)
        if self.head["order"] > 0:
            self.M1 = np.zeros((rows, columns, nq))
        return ""

    def put(self, which: str, place: tuple[int, ...], value: float) -> str:
        """Set an entry of a matrix; return a problem with its indices."""
        if which == "mn":
            return ""
        if (which == "m0") != (len(place) == 2):
            return f"{which} has {len(place)} indices"
        target = self.M0 if which == "m0" else self.M1
        if target is None:
            return "has m1 though its order is 0"
        at = place if which == "m0" else (place[0], place[2], place[1])
        if any(not 0 <= i < size for i, size in zip(at, target.shape, strict=True)):
            index = ", ".join(str(i + 1) for i in place)
            return f"{which}({index}) is outside of {' x '.join(map(str, target.shape))}"
        target[at] = value
        if which == "m0" and self.head["structure"] == SYMMETRIC:
            target[at[::-1]] = value
        return ""


@dataclass(eq=False)
class Node:
    """Node of the file: its name and its matrices."""

    number: str
    label: str = ""
    blocks: dict[str, Block] = field(default_factory=dict)


@dataclass(eq=False)
class Text:
    """Content of a file."""

    mass: float = float("nan")
    nodes: list[Node] = field(default_factory=list)
    blocks: dict[str, Block] = field(default_factory=dict)


def load_sid(path: Path, kind: type[P], versions: Mapping[str, str]) -> P:
    """Return a flexible body from standard input data (.sid, .SID_FEM).

    The integrals are those of Wallrapp (Mech. Struct. Mach. 22, 1994), as in `write_sid`; modes
    that are not orthonormal are replaced by the solutions of ``Ke x = omega^2 Me x``. Gr of first
    order contains the change of inertia with products of modal coordinates; without Gr this change
    and stiffening are left out. Stiffening follows from Oe and the node shapes, if both have
    first-order terms.

    Such files contain damping (De) but no modal stress: ``provenance["damping ratios"]`` has the
    ratios of the modes, for `FlexibleBody(damping=)`.

    Node sets are ``node1`` and so on, by the numbers in the file, and the names after "!" in files
    of `write_sid`.

    Raises
    ------
    InputError
        If a line cannot be read (the message contains it), or matrices are missing, of wrong size,
        not finite or not definite.

    Warns
    -----
    JoustoWarning
        With the content of the file that is left out.
    """
    where = path.name
    if path.is_dir():
        raise InputError(Problem(where, "is a folder, not standard input data"))
    check_input(path)
    if not path.exists():
        raise MissingFileError(Problem(str(path), "there is no such file"))
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError(Problem(where, "is larger than 2 GB"))
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise InputError(Problem(where, f"cannot be read: {error.strerror}")) from error
    found = _parse(text, where)
    _check(found, where)
    return _part(found, path, kind, versions)


# -- parsing -----------------------------------------------------------------------------------


def _parse(text: str, where: str) -> Text:
    """Return the content of a text."""
    found, problems = Text(), Problems()
    target, block, broken = found.blocks, None, False
    for number, raw in enumerate(text.splitlines()[1:], 2):
        line, _, comment = raw.partition("!")
        words = tuple(line.split())
        if len(problems.found) >= 10:
            break
        if not words or words in MARKS:
            continue
        at = f"{where}:{number}"
        if words[:2] == ("new", "node"):
            found.nodes.append(Node(words[-1]))
            target = found.nodes[-1].blocks
        elif words[0] == "end":
            block = None
            if words[1:] == ("node",):
                if found.nodes:
                    found.nodes[-1].label = comment.strip()
                target = found.blocks
        elif len(words) == 1 and "=" not in line:
            block, broken = Block(words[0], number), False
            target[words[0]] = block
        elif entry := _ENTRY.match(line.strip()):
            if block is not None and not broken:
                wrong = _entered(block, entry)
                broken = bool(wrong)
                if wrong:
                    problems.add(at, f"{block.name} {wrong}")
        elif match := _SAID.match(line.strip()):
            key, value = match[1], match[2].strip()
            wrong = ""
            if block is not None and key in HEAD:
                wrong = _headed(block, key, value)
            elif block is None and key == "mass":
                found.mass = _value(value)
            if wrong:
                problems.add(at, wrong)
                broken = True
        elif block is not None:
            problems.add(at, f"cannot read {line.strip()[:60]!r}")
    problems.raise_if_any()
    return found


def _headed(block: Block, key: str, value: str) -> str:
    try:
        block.head[key] = int(value)
    except ValueError:
        return f"{block.name}: {key} is {value[:40]!r}, must be a whole number"
    if key == "structure" and (wrong := block.begin()):
        return f"{block.name} {wrong}"
    return ""


def _entered(block: Block, entry: re.Match[str]) -> str:
    if "structure" not in block.head:
        return "has numbers before the line with its structure"
    value = _value(entry[5])
    if not np.isfinite(value):
        return f"has {entry[5][:40]!r}, must be a finite number"
    return block.put(entry[1], tuple(int(i) - 1 for i in entry.group(2, 3, 4) if i), value)


def _value(text: str) -> float:
    try:
        return float(text.replace("D", "E").replace("d", "e"))
    except ValueError:
        return float("nan")


def _check(found: Text, where: str) -> None:
    """Raise InputError for missing data and wrong sizes."""
    problems = Problems()
    if not (np.isfinite(found.mass) and found.mass > 0.0):
        problems.add(where, f"mass is {found.mass:g} kg, must be positive (refmod)")
    for name in NEEDED:
        if name not in found.blocks:
            problems.add(where, f"has no {name}; check that the file is standard input data")
    if not found.nodes:
        problems.add(where, "has no nodes, which joints and forces need")
    problems.raise_if_any()
    n = len(found.blocks["Me"].M0)
    if n == 0:
        problems.add(where, "has no modes; use a RigidBody")
    sizes = {"mdCM": (3, 1), "J": (3, 3), "Ct": (n, 3), "Cr": (n, 3), "Me": (n, n)}
    sizes |= {"Gr": (3, 3 * n), "Ke": (n, n), "Oe": (n, 6), "De": (n, n), "Ge": (n, 3 * n)}
    of_node = {"origin": (3, 1), "phi": (3, n), "psi": (3, n), "AP": (3, 3)}
    _sized(problems, where, found.blocks, sizes, n)
    for node in found.nodes:
        for name in ("origin", "phi"):
            if name not in node.blocks:
                problems.add(where, f"node {node.number} has no {name}")
        _sized(problems, f"{where}, node {node.number}", node.blocks, of_node, n)
    problems.raise_if_any()


def _sized(
    problems: Problems,
    where: str,
    blocks: Mapping[str, Block],
    sizes: Mapping[str, tuple[int, int]],
    n: int,
) -> None:
    for name, size in sizes.items():
        block = blocks.get(name)
        if block is None:
            continue
        if block.M0.shape != size:
            rows, columns = block.M0.shape
            message = f"{name} has {rows} x {columns} numbers, must have {size[0]} x {size[1]}"
            problems.add(where, message)
        elif block.M1 is not None and block.M1.shape[2] != n:
            message = f"{name} has {block.M1.shape[2]} modal coordinates, must have {n}"
            problems.add(where, message)


# -- reduced part ------------------------------------------------------------------------------


def _part(found: Text, path: Path, kind: type[P], versions: Mapping[str, str]) -> P:
    where = path.name
    blocks = found.blocks
    lost = [name for name in ("Ke", "De", "Ct", "Me") if _some(blocks.get(name), 1)]
    lost += [name for name in ("ksigma",) if _some(blocks.get(name), 0)]
    if lost:
        warn(where, f"{' and '.join(lost)}: stiffness, damping or inertia of higher order is left"
             " out")  # fmt: skip
    if any(np.abs(b.M0 - np.eye(3)).max() > SAME for b in _of_nodes(found, "AP")):
        warn(where, "nodes have local axes, which are ignored; markers have the axes of the body")
    X, frequencies = _modes(blocks["Ke"].M0, blocks["Me"].M0, where)
    nodes = np.array([node.blocks["origin"].M0[:, 0] for node in found.nodes])
    shapes = np.array([node.blocks["phi"].M0 for node in found.nodes])
    turning = [k for k, node in enumerate(found.nodes) if _some(node.blocks.get("psi"), 0)]
    turns = np.array([found.nodes[k].blocks["psi"].M0 for k in turning])
    inertia = _invariants(found, where)
    E = np.einsum("jkab,jl,km->lmab", inertia.E, X, X)
    return kind(
        name=path.stem,
        nodes=nodes,
        elements=np.zeros((0, 2), dtype=np.intp),
        node_sets=_sets(found),
        modes=shapes @ X,
        rotations=turns @ X if turning else None,
        frequencies=frequencies,
        invariants=Invariants(
            inertia.mass,
            inertia.first_moment,
            inertia.second_moment,
            inertia.I3 @ X,
            np.einsum("jab,jl->lab", inertia.N0, X),
            0.5 * (E + E.transpose(1, 0, 3, 2)),
        ),
        provenance={
            "method": "standard input data",
            **_damping(blocks, X, frequencies),
            **versions,
        },
        stiffening=_stiffening(found, inertia, X),
        rotation_nodes=np.array(turning) if 0 < len(turning) < len(nodes) else None,
    )


def _of_nodes(found: Text, name: str) -> list[Block]:
    return [node.blocks[name] for node in found.nodes if name in node.blocks]


def _some(block: Block | None, order: int) -> bool:
    """Return whether a block has nonzero numbers in the terms of an order."""
    matrix = None if block is None else (block.M1 if order else block.M0)
    return matrix is not None and bool(np.any(matrix))


def _sets(found: Text) -> dict[str, tuple[int, ...]]:
    sets: dict[str, tuple[int, ...]] = {
        f"node{node.number}": (k,) for k, node in enumerate(found.nodes)
    }
    labels = [node.label for node in found.nodes]
    for k, label in enumerate(labels):
        if re.fullmatch(r"[A-Za-z]\w*", label) and labels.count(label) == 1:
            sets.setdefault(label, (k,))
    return sets


def _modes(K: Array, M: Array, where: str) -> tuple[Array, Array]:
    """Return the orthonormal modes in terms of those of the file (n, n), and frequencies, Hz."""
    problems = Problems()
    for name, matrix in (("Ke", K), ("Me", M)):
        if np.abs(matrix - matrix.T).max() > SAME * np.abs(matrix).max(initial=0.0):
            problems.add(where, f"{name} is not symmetric")
    problems.raise_if_any()
    scale = np.abs(np.diag(K)).max()
    off = np.abs(K - np.diag(np.diag(K))).max()
    if np.abs(M - np.eye(len(M))).max() < 1e-9 and off < 1e-9 * scale:
        values, X = np.diag(K), np.eye(len(M))
    else:
        try:
            values, X = scipy.linalg.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
        except scipy.linalg.LinAlgError:
            message = "Me is not positive definite: its modes are linearly dependent"
            raise InputError(Problem(where, message)) from None
    if values.min() <= 0.0:
        message = f"Ke is not positive definite: {count(int(np.sum(values <= 0)), 'mode')} without"
        raise InputError(Problem(where, f"{message} stiffness; leave out rigid motions"))
    return X, np.sqrt(values) / (2.0 * np.pi)


def _invariants(found: Text, where: str) -> Invariants:
    """Return the mass integrals of the modes of the file."""
    blocks = found.blocks
    J, Gr = blocks["J"].M0, blocks["Gr"]
    n = len(blocks["Me"].M0)
    # blocks of three columns per mode: 2 I8[j], 2 I9[k, j]
    N0 = outer(0.5 * Gr.M0.reshape(3, n, 3).transpose(1, 0, 2))
    if Gr.M1 is not None and np.any(Gr.M1):
        E = outer(0.5 * Gr.M1.reshape(3, n, 3, n).transpose(3, 1, 0, 2))
    else:
        warn(where, "Gr is not of first order: the change of inertia with products of modal "
            "coordinates"
            " and stiffening are left out")  # fmt: skip
        E = blocks["Me"].M0[:, :, None, None] / 3.0 * np.eye(3)
        Cr = blocks["Cr"].M1
        if Cr is not None:  # I5[j, a, i] at row i, column a, coordinate j
            E = E + 0.5 * np.einsum("abc,iaj->jibc", EPS, Cr)
    E = 0.5 * (E + E.transpose(1, 0, 3, 2))
    I3 = blocks["Ct"].M0.T
    made = Invariants(
        found.mass, blocks["mdCM"].M0[:, 0], 0.5 * np.trace(J) * np.eye(3) - J, I3, N0, E
    )
    # upper bounds by Cauchy-Schwarz: int u phi dm <= sqrt(int u^2 dm int phi^2 dm)
    modal = float(np.abs(blocks["Me"].M0).max())
    length, mass = (float(np.sqrt(x * modal)) for x in (np.trace(J), found.mass))
    twice = (
        ("Cr and Gr", blocks["Cr"].M0.T, made.I4, length),
        ("Me and Gr", blocks["Me"].M0, made.I6, modal),
        ("mdCM and Ct", blocks["mdCM"].M1, I3[:, None, :], mass),
    )
    for names, one, other, size in twice:
        gap = 0.0 if one is None else float(np.abs(one - other).max()) / size
        if gap > SAME:
            warn(where, f"{names} differ by {gap:.1e} of their size; {names[-2:]} is used")
    return made


def _stiffening(found: Text, inertia: Invariants, X: Array) -> Stiffening | None:
    """Return second-order displacements, if node shapes and Oe have first-order terms."""
    fields: dict[str, Any] = {}
    for name in ("phi", "psi"):
        ones = [node.blocks[name].M1 if name in node.blocks else None for node in found.nodes]
        zero = np.zeros((3, len(X), len(X)))
        fields[name] = np.array([zero if one is None else one for one in ones])
    Oe, Gr = found.blocks.get("Oe"), found.blocks["Gr"]
    if not np.any(fields["phi"]) or Oe is None or Oe.M1 is None or Gr.M1 is None:
        return None
    n = len(X)
    change = np.zeros((n, n, 3, 3))
    for column, (a, b) in enumerate(SPIN):
        change[:, :, a, b] += 0.5 * Oe.M1[:, column, :]
        change[:, :, b, a] += 0.5 * Oe.M1[:, column, :]
    I9 = inertia.I9
    N = outer(-change - 0.5 * (I9 + I9.transpose(0, 1, 3, 2)))
    N = 0.5 * (N + N.transpose(1, 0, 2, 3))
    turned = [np.einsum("iajk,jl,km->ialm", fields[name], X, X) for name in ("phi", "psi")]
    return Stiffening(np.einsum("jkab,jl,km->lmab", N, X, X), *turned)


def _damping(blocks: Mapping[str, Block], X: Array, frequencies: Array) -> dict[str, str]:
    if not _some(blocks.get("De"), 0):
        return {}
    rates = np.diag(X.T @ blocks["De"].M0 @ X)
    ratios = rates / (4.0 * np.pi * frequencies)
    return {"damping ratios": ", ".join(f"{ratio:.6g}" for ratio in ratios)}
