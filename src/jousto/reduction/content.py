"""Content: the data of a reduced part, as in its files, with checks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import Problems, suggest
from jousto.base.frozen_dict import Frozen
from jousto.parts.frames.element import BeamElements
from jousto.parts.frames.outlines import Outlines
from jousto.reduction.fields.invariants import Invariants
from jousto.reduction.fields.stiffening import Stiffening
from jousto.reduction.fields.stress import StressModes

if TYPE_CHECKING:
    from jousto.parts.part import Part


@dataclass(frozen=True, eq=False)
class Content:
    """Checked data of a `ReducedPart`; see `ReducedPart` for the attributes."""

    name: str
    nodes: Array
    elements: NDArray[np.intp]
    node_sets: Mapping[str, tuple[int, ...]]
    modes: Array
    rotations: Array | None
    frequencies: Array
    invariants: Invariants
    stress: StressModes | Any = None
    interfaces: tuple[str, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=dict)
    stiffening: Stiffening | None = None
    rotation_nodes: NDArray[np.intp] | None = None
    faces: tuple[NDArray[np.intp], ...] = ()
    beams: BeamElements | None = None
    outlines: Outlines | None = None
    source: Part | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        where = f"reduced part '{self.name}'"
        problems = Problems()
        nodes = problems.array(where, "nodes", self.nodes, (None, 3))
        nn = 0 if nodes is None else len(nodes)
        f = problems.array(where, "frequencies", self.frequencies, (None,))
        n = 0 if f is None else len(f)
        modes = problems.array(where, "modes", self.modes, (nn, 3, n))
        rotations = self.rotations
        turning = self.rotation_nodes
        if turning is not None:
            turning = np.array(turning, dtype=np.intp)
            if turning.ndim != 1 or np.any(np.diff(turning) <= 0):
                problems.add(where, "rotation_nodes are not node numbers in ascending order")
            elif len(turning) and not (0 <= turning[0] and turning[-1] < nn):
                problems.add(where, f"rotation_nodes refer to nodes outside 0..{nn - 1}")
            if rotations is None:
                problems.add(where, "rotation_nodes are given without rotations; leave them out")
            turning.setflags(write=False)
        if rotations is not None:
            count = nn if turning is None else len(turning)
            rotations = problems.array(where, "rotations", rotations, (count, 3, n))
        if f is not None and n == 0:
            problems.add(where, "there are no modes; use a RigidBody")
        if f is not None and n and f.min() <= 0.0:
            problems.add(where, f"a frequency is {f.min():g} Hz, must be positive")
        if self.invariants.n != n:
            problems.add(where, f"invariants have {self.invariants.n} modes, frequencies {n}")
        if self.stress is not None and self.stress.modes.shape[2] != n:
            problems.add(where, f"stress has {self.stress.modes.shape[2]} modes, must have {n}")
        if self.stiffening is not None:
            found = self.stiffening.translations.shape
            if found != (nn, 3, n, n):
                problems.add(where, f"stiffening has {found[0]} nodes and {found[3]} modes")

        # node numbers of elements and sets
        elements = np.array(self.elements, dtype=np.intp)
        if elements.ndim != 2:
            problems.add(where, f"elements has shape {elements.shape}, must be (any, any)")
        elif elements.size and not (0 <= elements.min() and elements.max() < nn):
            problems.add(where, f"elements refer to nodes outside 0..{nn - 1}")
        if self.beams is not None and elements.shape != (len(self.beams), 2):
            problems.add(where, f"beams are {len(self.beams)}, elements {elements.shape}")
        if self.outlines is not None and self.outlines.which.shape != (len(elements),):
            problems.add(
                where,
                f"outlines have {len(self.outlines.which)} elements, the part has {len(elements)}",
            )
        faces = tuple(np.array(face, dtype=np.intp) for face in self.faces)
        for face in faces:
            if face.ndim != 2 or face.shape[1] not in (3, 4, 6, 8):
                problems.add(where, f"faces have shape {face.shape}, must be (any, 3, 4, 6 or 8)")
            elif face.size and not (0 <= face.min() and face.max() < nn):
                problems.add(where, f"faces refer to nodes outside 0..{nn - 1}")
            face.setflags(write=False)
        sets = {str(k): tuple(int(i) for i in v) for k, v in self.node_sets.items()}
        for key, members in sets.items():
            if any(not 0 <= i < nn for i in members):
                problems.add(where, f"node set '{key}' refers to nodes outside 0..{nn - 1}")
        for key in self.interfaces:
            if key not in sets:
                problems.add(where, f"interface '{key}' is not a node set{suggest(key, sets)}")
        problems.raise_if_any()

        elements.setflags(write=False)
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "elements", elements)
        object.__setattr__(self, "node_sets", Frozen(sets))
        object.__setattr__(self, "modes", modes)
        object.__setattr__(self, "rotations", rotations)
        object.__setattr__(self, "rotation_nodes", turning)
        object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "frequencies", f)
        object.__setattr__(self, "interfaces", tuple(self.interfaces))
        object.__setattr__(self, "provenance", Frozen(dict(self.provenance)))
