"""Parts and instances of Abaqus input files: positions, names and numbers."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import suggest
from jousto.base.rotations import exp_rotation
from jousto.mesh.readers.inp_blocks import Block, real


@dataclass
class Instance:
    """Instance of a part at its position: ``x' = R (x + t - a) + a``.

    Attributes
    ----------
    name : str
    blocks : list of Block
        Blocks of its part and of the instance.
    move : (3,) ndarray
        Translation t, applied first.
    turn : (3, 3) ndarray
        Rotation R, applied second.
    about : (3,) ndarray
        Point a of the axis of rotation.
    shift : int
        Number added to its node and element numbers.
    prefix : str
        Prefix of its names: ``A-1.``; empty for a single instance.
    """

    name: str
    blocks: list[Block]
    move: Array = field(default_factory=lambda: np.zeros(3))
    turn: Array = field(default_factory=lambda: np.eye(3))
    about: Array = field(default_factory=lambda: np.zeros(3))
    shift: int = 0
    prefix: str = ""

    def place(self, x: Array) -> Array:
        """Return positions (n, 3) in the assembly."""
        return np.asarray((x + self.move - self.about) @ self.turn.T + self.about)

    def stand(self, block: Block) -> None:
        """Read the data lines of ``*INSTANCE``: a translation, then two points and an angle."""
        rows = [row for row in block.rows if any(row)] if block.lines else []
        try:
            numbers = [np.array([real(word) for word in row]) for row in rows]
        except ValueError:
            numbers = [np.full(1, np.nan)]
        sizes = [len(row) for row in numbers]
        if sizes not in ([], [3], [3, 7]) or not all(np.isfinite(row).all() for row in numbers):
            raise block.wrong(
                "needs x, y, z of its translation, then two points of an axis and degrees"
            )
        if numbers:
            self.move = numbers[0]
        if len(numbers) > 1:
            a, b, angle = numbers[1][:3], numbers[1][3:6], numbers[1][6]
            if not np.linalg.norm(b - a) > 0.0:
                raise block.wrong("the two points of its axis coincide")
            self.about = a
            self.turn = exp_rotation(np.radians(angle) * (b - a) / np.linalg.norm(b - a))


@dataclass
class Assembly:
    """Content of a deck: instances, and blocks that belong to no instance.

    Attributes
    ----------
    instances : list of Instance
    model : list of Block
        Other blocks, in order; their sets may refer to the instances.
    """

    instances: list[Instance]
    model: list[Block]

    def find(self, block: Block, name: str) -> Instance:
        """Return the instance with a name, or raise InputError."""
        for instance in self.instances:
            if instance.name.upper() == name.upper():
                return instance
        known = [instance.name for instance in self.instances]
        raise block.wrong(f"there is no instance '{name}'{suggest(name, known)}")

    def split(self, word: str) -> tuple[Instance | None, str]:
        """Return the instance and the rest of a word such as ``A-1.corner`` or ``A-1.17``."""
        for instance in self.instances:
            head = f"{instance.name}."
            if word.upper().startswith(head.upper()):
                return instance, word[len(head) :]
        return None, word


def assembly(blocks: Iterable[Block]) -> Assembly:
    """Return the instances of a deck with their blocks.

    A deck without parts has no instances; a part without an instance keeps its coordinates.

    Raises
    ------
    InputError
        If an instance has no part or is imported from another model.
    """
    parts: dict[str, list[Block]] = {}
    names: list[str] = []
    found = Assembly([], [])
    here = found.model
    for block in blocks:
        if block.keyword == "PART":
            here = parts.setdefault(block.text("NAME").upper(), [])
            names.append(block.text("NAME"))
        elif block.keyword == "INSTANCE":
            here = _instance(block, parts, found, names)
        elif block.keyword in ("END PART", "END INSTANCE"):
            here = found.model
        else:
            here.append(block)
    if not found.instances:
        found.instances = [Instance(name, parts[name.upper()]) for name in dict.fromkeys(names)]
    if len(found.instances) > 1:
        for instance in found.instances:
            instance.prefix = f"{instance.name}."
    return found


def _instance(
    block: Block, parts: dict[str, list[Block]], found: Assembly, names: list[str]
) -> list[Block]:
    """Add an instance, and return the list for its blocks."""
    name, part = block.text("NAME"), block.text("PART")
    if "LIBRARY" in block.parameters or "INSTANCE" in block.parameters:
        raise block.wrong("is taken from the results of another analysis; export its mesh")
    if part.upper() not in parts:
        known = suggest(part, names)
        raise block.wrong(f"there is no part '{part}' above it{known}")
    if any(other.name.upper() == name.upper() for other in found.instances):
        raise block.wrong(f"there are two instances '{name}'")
    new = Instance(name, list(parts[part.upper()]))
    new.stand(block)
    found.instances.append(new)
    return new.blocks


def step_above(numbers: list[Ints]) -> int:
    """Return the smallest power of ten that is larger than all numbers."""
    most = max((int(n.max(initial=1)) for n in numbers), default=1)
    return int(10 ** len(str(max(most, 1))))


def is_number(word: str) -> bool:
    """Return whether a word is a whole number."""
    return re.fullmatch(r"[+-]?\d+", word) is not None
