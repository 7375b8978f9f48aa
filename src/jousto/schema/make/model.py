"""Construction of parts, bodies and a mechanism from validated entries."""

from __future__ import annotations

import warnings
from typing import Any

from jousto.base.errors import InputError, Problems
from jousto.base.names import check_name
from jousto.mechanism.assembly import Assembly
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.rigid_equivalent import rigid_body
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.foreign.fmu import Fmu
from jousto.mechanism.joints.base import align_frames
from jousto.mechanism.mechanism import Mechanism, where
from jousto.schema.entries import model as sm, parts as sp
from jousto.schema.file.document import Loc
from jousto.schema.make.blocks.fatigue import FORMS as OF_FATIGUE, build_curves
from jousto.schema.make.builder import Builder, Section
from jousto.schema.make.declared import build_declared, check_names
from jousto.schema.make.elements import FORMS as OF_FORCES
from jousto.schema.make.foreign import FORMS as OF_FMUS
from jousto.schema.make.machines import FORMS as OF_ROBOTS, JOINED, PREFIX_ENDS, Joined
from jousto.schema.make.matrices import build_matrices, build_superelement, is_superelement
from jousto.schema.make.sensors import FORMS as OF_SENSORS
from jousto.schema.make.solid import FORMS as OF_PARTS, build_solid
from jousto.schema.make.states import FORMS as OF_STATES

LISTS = (
    *(
        "bodies",
        "robots",
        "joints",
        "elastic_joints",
        "couplings",
        "forces",
        "states",
        "frictions",
        "initial",
        "sensors",
        "events",
    ),
    "fmus",
)

MOST_KEPT = 64
"""Reduced parts of variants of a file that are kept, the one made first goes first."""


class ModelBuilder(Builder):
    """Builds parts, bodies and the mechanism of a document."""

    forms = {
        **OF_FORCES,
        **OF_SENSORS,
        **OF_FMUS,
        **OF_ROBOTS,
        **OF_PARTS,
        **OF_FATIGUE,
        **OF_STATES,
    }

    # -- parts ------------------------------------------------------------------------------

    def part_name(self, loc: Loc, name: Any) -> bool:
        """Return whether a name is valid for a part and its file; add a problem if not."""
        problems = Problems()
        check_name(problems, "part", name)
        for problem in problems.found:
            self.note(loc, problem.message)
        return not problems.found

    def reduced(self, loc: Loc, name: str, entry: Any) -> Any:
        """Return the ReducedPart of an entry of parts; None, with problems, if it is invalid."""
        from jousto.reduction.reduced import ReducedPart

        if entry.in_plane is not None and entry.keep is not None:
            self.note((*loc, "keep"), "give either keep or in_plane, not both")
            return None
        if isinstance(entry, sp.ReducedEntry):
            reduced = self.make((*loc, "file"), ReducedPart.load, self.file(entry.file))
            return self.chosen(loc, entry, reduced)
        if is_superelement(entry):
            return self.chosen(loc, entry, build_superelement(self, loc, name, entry))
        part = self.part(loc, name, entry)
        method = self.method(loc, entry, part)
        return self.reduction(loc, entry, part, method)

    def recalled(self, loc: Loc, name: str, entry: Any) -> Any:
        """Return the ReducedPart that another variant built from the same entry, or a new one."""
        place = (name, repr(self.document.at(loc)))
        if place not in self.kept:
            reduced = self.reduced(loc, name, entry)
            if reduced is None:
                return None
            self.kept[place] = reduced
            while len(self.kept) > MOST_KEPT:
                del self.kept[next(iter(self.kept))]
        return self.kept[place]

    def method(self, loc: Loc, entry: Any, part: Any = None) -> Any:
        """Return the CraigBampton or FreeFree of an entry; None if it is invalid."""
        return build_declared(self, (*loc, "reduce"), entry.reduce, {"part": part})

    def reduction(self, loc: Loc, entry: Any, part: Any, method: Any) -> Any:
        """Return the reduction of a part by an entry; None, with problems, if it fails."""
        from jousto.reduction.reducer import reduce

        if part is None or method is None:
            return None
        options: dict[str, Any] = {
            key: value
            for key in ("stiffening", "residual_stress", "solver", "cache")
            if (value := getattr(entry, key, None)) is not None
        }
        options |= self.options
        reduced = self.make((*loc, "reduce"), reduce, part, method, **options)
        return self.chosen(loc, entry, reduced)

    def chosen(self, loc: Loc, entry: Any, reduced: Any) -> Any:
        """Return the ReducedPart with the modes that the entry keeps."""
        if reduced is not None and entry.in_plane is not None:
            modes = reduced.in_plane(entry.in_plane)
            reduced = self.make((*loc, "in_plane"), reduced.keep, modes)
        elif reduced is not None and entry.keep is not None:
            reduced = self.make((*loc, "keep"), reduced.keep, entry.keep)
        return reduced

    def part(self, loc: Loc, name: str, entry: Any) -> Any:
        """Return the Part of an entry with a mesh; None, with problems, if it is invalid."""
        if entry.type == "matrices":
            return build_matrices(self, loc, name, entry)
        if entry.type == "solid":
            return build_solid(self, loc, name, entry)
        from jousto.parts.part import Part

        form = build_declared(self, loc, entry, more={"name": name})
        return None if form is None else self.make(loc, Part.of, form)

    # -- mechanism --------------------------------------------------------------------------

    def named_part(self, loc: Loc, entry: Any) -> Any:
        """Return the ReducedPart of an entry of parts; None, with problems, if it is invalid."""
        name: Any = loc[-1]
        return self.recalled(loc, name, entry) if self.part_name(loc, name) else None

    def lost(self, name: str) -> bool:
        """Return whether a name may belong to a robot that could not be built."""
        bodies = self.known.get("bodies")
        return isinstance(bodies, Joined) and bodies.lost(name)

    def frame(self, name: str) -> Any:
        """Return a named frame of a robot; None if there is no such frame."""
        bodies = self.known.get("bodies")
        return bodies.frame(name) if isinstance(bodies, Joined) else None

    def item(self, loc: Loc, entry: Any) -> Any:
        """Return the object of an entry of a list; None, with problems, if it is invalid."""
        made = build_declared(self, loc, entry, self.known)
        if isinstance(made, Fmu) and not self.trust:
            object.__setattr__(made, "untrusted", self.document.where((*loc, "file")))
        return rigid_body(made) if self.rigid and isinstance(made, FlexibleBody) else made

    def check_names(self, entries: list[tuple[Loc, Any]], wrong: set[Loc]) -> None:
        """Add a problem for each unknown name in entries that are invalid for other reasons.

        Parameters
        ----------
        entries : list of (path, class)
            Paths of the entries of lists, and the classes as which they are read.
        wrong : set of paths
            Paths already known as invalid.
        """
        for loc, entry in entries:
            check_names(self, loc, entry.declared, self.document.at(loc), self.known, wrong)

    def mechanism(self, entry: sm.ModelEntry, index: dict[str, list[int]]) -> Any:
        """Return the Mechanism of a file; None, with problems, if it is invalid.

        Parameters
        ----------
        entry : ModelEntry
            The validated file, or its valid entries.
        index : dict
            For each list the places of its entries in the file.
        """
        self.sensors = [e.name for e in entry.sensors or ()]
        known = self.known
        known["curves"] = self.curves = build_curves(self, entry.fatigue)
        parts = [(name, ("parts", name), part) for name, part in (entry.parts or {}).items()]
        known["parts"] = made = Section(self, "parts", parts, self.named_part)
        sections = [made]
        # a rigid body has neither modes nor stress; sensors of these quantities, and damage of such
        # sensors, are left out
        gone = [e.name for e in entry.sensors or () if self.rigid and e.declared.flexible]
        for key in LISTS:
            entries: list[tuple[Any, Loc, Any]] = [
                (getattr(e, "name", None), (key, i), e)
                for i, e in zip(index[key], getattr(entry, key) or (), strict=True)
                if not (self.rigid and getattr(e.declared, "flexible", False))
                and not (gone and getattr(e, "sensor", None) in gone)
            ]
            known[key] = made = Section(self, key, entries, self.item)
            sections.append(made)
        named = {made.key: made for made in sections}
        groups = [named[key] for key in PREFIX_ENDS]
        known |= {key: Joined(named[key], groups, key) for key in JOINED}
        self.sensors = list(dict.fromkeys([*self.sensors, *known["sensors"]]))
        items: list[tuple[Loc, Any]] = []
        with self.catching():  # catch the warnings of all items together
            for made in sections:
                found = made.all()
                if made.key == "joints":
                    align_frames(joint for _, joint in found)
                items += found if made.key != "parts" else []
        if not known["bodies"] and (self.found or self.broken):
            return None
        gravity = [] if entry.gravity is None else [Gravity(entry.gravity)]
        name = entry.name or "mechanism"
        settings = {} if entry.simulation is None else entry.simulation.given()
        return self.checked(items, gravity, name, settings)

    def checked(
        self, items: list[tuple[Loc, Any]], gravity: list[Any], name: str, settings: Any
    ) -> Any:
        """Return the Mechanism; add its problems at the entries concerned."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                made = Mechanism(
                    *(item for _, item in items),
                    *gravity,
                    name=name,
                    core=settings.get("core", "auto"),
                    start=settings.get("start", "initial"),
                )
            except InputError as error:
                places, inner = places_of(items)
                for problem in error.problems:
                    loc = places.get(problem.where, ())
                    head = "" if loc else f"{problem.where}: "
                    self.note_problem(loc or inner.get(problem.where, ()), problem, head)
                return None
        # with invalid items the warnings would be misleading
        if caught and not (self.found or self.broken):
            places, inner = places_of(items)
            for item in caught:
                place = getattr(item.message, "where", "")
                if place in inner:
                    self.warn(inner[place], item, set())
                else:
                    self.warn(places.get(place, ()), item, {place.lower()})
        return made


def places_of(items: list[tuple[Loc, Any]]) -> tuple[dict[str, Loc], dict[str, Loc]]:
    """Return the path of each item, robot items included, by its name in messages."""
    own = {where(item): loc for loc, item in items}
    robots = [(loc, item) for loc, item in items if isinstance(item, Assembly)]
    return own, {where(x): loc for loc, robot in robots for x in robot.items}
