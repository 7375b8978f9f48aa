"""Frame of the beams in an Abaqus or CalculiX input file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints, some
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.fields import AnyField, Label, OptionalText, field
from jousto.base.numbers import set_fields
from jousto.mesh.readers.element_types import BEAM, TRUSS, abaqus
from jousto.mesh.readers.inp import Deck, loads_left_out, read_deck
from jousto.mesh.readers.raw import Numbers, joined
from jousto.parts.frames.deck_sections import (
    ROUND,
    DeckSection,
    deck_materials,
    deck_section,
    numbers,
)
from jousto.parts.frames.element import EulerBernoulli, Timoshenko
from jousto.parts.frames.forms import frame_fields
from jousto.parts.frames.frame import BeamOptions, FrameArrays, check_frame
from jousto.parts.mass import PointMass
from jousto.parts.matrices.units import Units

SLENDER = ("B23", "B23H", "B33", "B33H")
"""Element types without shear deformation."""

UNREAD = (
    *("RELEASE", "BEAM ADDED INERTIA", "NONSTRUCTURAL MASS", "TRANSVERSE SHEAR STIFFNESS"),
    *("SPRING", "DASHPOT", "CONNECTOR SECTION", "NORMAL", "ROTARY INERTIA"),
)
"""Keywords with an effect on a frame that are not read."""

REFUSED = ("ELBOW31", "FRAME2D", "FRAME3D")


class BeamDeck(BeamOptions, tag="beam-deck"):
    """Frame that consists of the beams in an Abaqus or CalculiX input file.

    Nodes, elements, sections with their axes, materials, sets and point masses are those of the
    file; ``n17`` is the node with the number 17 there. Supports and loads are ignored. ``B33`` are
    beams without shear deformation. ``B31`` and ``B32`` become beams that are exact between their
    nodes; in Abaqus they are interpolated linearly or quadratically. The middle node of a ``B32``
    becomes a node of the frame.

    Raises
    ------
    InputError
        With all problems: no beams, a beam without a section, an unsupported section, an axis n1
        parallel to its beam.

    Warns
    -----
    JoustoWarning
        With the element types that are replaced, and the keywords of the file that are ignored.
    """

    deck: AnyField = field("The file, .inp", form="file", noun="str or Path")
    units: Label = field(
        "Units of the file, such as SI, mm-t-s, in-lbf-s", default="SI", kw_only=True
    )
    name: OptionalText = field(
        "Name of the part; None for the name of the file", file=False, default=None, kw_only=True
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages, with the name of the file for a part without a name."""
        if vars(self)["name"] is None:
            set_fields(self, name=Path(str(self.deck)).stem)
        return f"part '{self.name}'"

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the deck."""
        path = Path(self.deck)
        options = {key: getattr(self, key) for key in BeamOptions.fields}
        return frame_fields(check_frame(deck_frame(path, Units.read(self.units), options)))


@dataclass
class _Beams:
    """Beams in the numbering of the file: ends (ne, 2), numbers (ne,), types."""

    ends: Ints
    ids: Ints
    types: list[str]


def deck_frame(path: Path, units: Units, options: Mapping[str, Any]) -> FrameArrays:
    """Return the arrays of the beams of a deck.

    Raises
    ------
    InputError
        See `BeamDeck`.
    """
    from jousto.mesh.readers.files import exists, which

    exists(path)
    which(path)
    deck = read_deck(path)
    beams = _beams(path, deck)
    sections = _sections(path, deck, units, beams)
    mesh = deck.raw.build(path.name, path.stem, units.length)
    index = Numbers(np.asarray(mesh.node_ids))
    used = np.unique(index(beams.ends.ravel()))
    new = np.full(len(mesh.nodes), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    ends = new[index(beams.ends.ravel())].reshape(-1, 2)
    nodes = np.asarray(mesh.nodes)[used]
    up, offsets = _orientations(path, beams, sections, nodes[ends])
    sets = {key: new[np.asarray(value)] for key, value in mesh.node_sets.items()}
    kept = {key: value[value >= 0].tolist() for key, value in sets.items() if max(value) >= 0}
    labels = np.asarray(mesh.node_ids)[used]
    kept = {f"n{label}": [i] for i, label in enumerate(labels)} | kept
    masses = (*options["point_masses"], *_masses(deck, units, index, new))
    _warn(path, deck, beams)
    return FrameArrays(
        nodes,
        ends,
        sections=[s.section for s in sections],
        materials=[s.material for s in sections],
        orientations=up,
        offsets=offsets,
        node_sets=kept,
        **{
            **options,
            "theory": options["theory"] or _theory(beams),
            "point_masses": masses,
        },
    )


def _beams(path: Path, deck: Deck) -> _Beams:
    """Return the beams of a deck; a beam with a middle node becomes two."""
    ends, ids, types = [], [], []
    for block in deck.raw.cells:
        known = abaqus(block.type)
        if known is None or known.replaced != BEAM:
            continue
        if block.type in REFUSED:
            raise InputError(
                Problem(path.name, f"{block.type} is not supported; use B31, B32 or B33")
            )
        pairs = block.nodes.reshape(len(block.nodes), -1)
        # the middle node of `line3` is the last one
        chains = [pairs] if known.kind == "line" else [pairs[:, [0, 2]], pairs[:, [2, 1]]]
        for chain in chains:
            ends.append(chain)
            ids.append(block.ids)
            types += [block.type] * len(chain)
    if not ends:
        held = Counter[str]()
        for block in deck.raw.cells:
            held[block.type] += len(block.ids)
        held += deck.raw.unread
        names = some([f"{name} ({n})" for name, n in held.most_common()]) or "no elements"
        raise InputError(Problem(path.name, f"has no beams (B31, B32, B33); it has {names}"))
    return _Beams(np.concatenate(ends), np.concatenate(ids), types)


def _theory(beams: _Beams) -> Timoshenko | EulerBernoulli:
    """Return one theory for all beams: without shear deformation if no beam has it."""
    slender = all(name in SLENDER for name in beams.types)
    return EulerBernoulli() if slender else Timoshenko()


def _sections(path: Path, deck: Deck, units: Units, beams: _Beams) -> list[DeckSection]:
    """Return the section of each beam; raise an error for beams without section or with two."""
    materials = deck_materials(deck.others, units)
    ids = deck.raw.numbers(nodes=False)
    owner, read = np.full(len(beams.ids), -1), list[DeckSection | None]()
    problems = Problems()
    for title, block, instance in deck.sections:
        if block.keyword not in ("BEAM SECTION", "BEAM GENERAL SECTION"):
            continue
        members = np.isin(beams.ids, joined(deck.raw.element_sets.get(title, []), ids))
        twice = members & (owner >= 0)
        if twice.any():
            named = some([str(i) for i in np.unique(beams.ids[twice])])
            problems.add(block.where, f"element {named} has two sections", "element")
        owner[members] = len(read)
        try:
            read.append(deck_section(block, instance.turn, materials, units))
        except InputError as error:
            problems.found += error.problems
            read.append(None)
    bare = np.unique(beams.ids[owner < 0])
    if len(bare):
        named = some([str(i) for i in bare])
        problems.add(
            path.name, f"element {named} has no *BEAM SECTION; give its set one", "element"
        )
    problems.raise_if_any()
    return [section for i in owner if (section := read[i]) is not None]


def _orientations(
    path: Path, beams: _Beams, sections: list[DeckSection], x: Array
) -> tuple[Array, Array]:
    """Return vectors near the local z axes (ne, 3) and arms to the centroids (ne, 2, 3), m.

    With the tangent t, axis 2 is ``n2 = t x n1``; z is n2 rotated to the principal axis.
    """
    t = x[:, 1] - x[:, 0]
    length = np.linalg.norm(t, axis=1)
    t = t / np.where(length > 0.0, length, 1.0)[:, None]
    n1 = np.array([s.n1 for s in sections])
    n2 = np.cross(t, n1)
    size = np.linalg.norm(n2, axis=1)
    along = size <= 1e-6 * np.linalg.norm(n1, axis=1)
    free = np.array([isinstance(s.section, ROUND) for s in sections])
    if np.any(along & ~free):
        named = some([str(i) for i in np.unique(beams.ids[along & ~free])])
        message = f"element {named}: n1 is parallel to the beam; give another axis in *BEAM SECTION"
        raise InputError(Problem(path.name, message))
    # a round section has no preferred axes: any vector across the beam
    n2[along] = np.cross(t[along], np.roll(t[along], 1, axis=1))
    n2 = n2 / np.linalg.norm(n2, axis=1)[:, None]
    n1 = np.cross(n2, t)
    angle = np.array([s.turn for s in sections])[:, None]
    up = np.cos(angle) * n2 - np.sin(angle) * n1
    arms = np.array([s.shift for s in sections])[:, None] * n2
    return up, np.repeat(arms[:, None], 2, axis=1)


def _masses(deck: Deck, units: Units, index: Numbers, new: Ints) -> list[PointMass]:
    """Return the point masses ``*MASS`` of nodes of the frame."""
    out = []
    for block, nodes in deck.masses:
        mass = (*numbers(block, 0), 0.0)[0] * units.mass
        at = np.where((found := index(nodes)) < 0, -1, new[found])
        lost = [str(n) for n, i in zip(nodes, at, strict=True) if i < 0]
        if lost:
            raise block.wrong(f"node {some(lost)} belongs to no beam")
        out += [PointMass(int(i), mass) for i in at]
    return out


def _warn(path: Path, deck: Deck, beams: _Beams) -> None:
    """Warn about element types that are replaced and keywords that are ignored."""
    number = Counter(dict.fromkeys(beams.types, 0))
    for name in beams.types:
        number[name] += 1
    others = {name: n for name, n in number.items() if name not in SLENDER}
    if others:
        names = some([f"{n} {name}" for name, n in others.items()])
        slender = [name for name in number if name in SLENDER]
        more = f"; {some(slender)} get shear deformation, too" if slender else ""
        warn(
            path.name,
            f"{names} read as beams that are exact between their nodes, with the shear coefficients"
            f" of Cowper{more}",
        )
    rest = Counter[str]()
    for block in deck.raw.cells:
        known = abaqus(block.type)
        if known is not None and known.replaced != BEAM:
            rest[block.type] += len(block.ids)
    if rest:
        names = some([f"{n} {name}" for name, n in rest.items()])
        trusses = any((known := abaqus(name)) and known.replaced == TRUSS for name in rest)
        hint = "; give trusses a *BEAM SECTION and the type B31" if trusses else ""
        warn(path.name, f"{names} left out: a frame contains beams only{hint}")
    for place, sentence in deck.raw.left_out:
        if "of type MASS" not in sentence:
            warn(place, sentence)
    words = dict.fromkeys(block.keyword for block in deck.others if block.keyword in UNREAD)
    if words:
        warn(path.name, f"{', '.join(f'*{word}' for word in words)} not read: left out of the part")
    if outside := loads_left_out(deck, path):
        warn(path.name, outside)
