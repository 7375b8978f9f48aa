"""From validated entries to parts, bodies and a mechanism, through the Python constructors."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from jousto.base.errors import InputError, JoustoWarning, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.base.rotations import Rotate
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.mechanism import Mechanism
from jousto.schema.entries import model as sm, parts as sp
from jousto.schema.entries.base import Entry, MarkerEntry, RotateEntry
from jousto.schema.entries.beams import BeamBodyEntry
from jousto.schema.entries.fatigue import build_curves
from jousto.schema.entries.solids import SolidEntry
from jousto.schema.file.document import Document, Loc
from jousto.schema.make.beam import build_beam
from jousto.schema.make.declared import FORMS, build_declared
from jousto.schema.make.elements import FORMS as OF_FORCES
from jousto.schema.make.happen import is_late, watches_late
from jousto.schema.make.matrices import build_matrices, build_superelement, is_superelement
from jousto.schema.make.sense import FORMS as OF_SENSORS
from jousto.schema.make.solid import build_solid

T = TypeVar("T")
MOST_HINTS = 100  # problems of a file that come with likely names


class Builder:
    """Builds the objects of one document and collects problems with their lines.

    Parameters
    ----------
    document : Document
        For lines, and the folder of files it refers to.
    broken : iterable of (str, str or None)
        Sections and names of entries that failed before; references to them are not reported
        again. None stands for any name.
    rigid : bool
        Whether flexible bodies are made rigid.
    trust : bool
        Whether Python code that the document names may run.
    options : mapping, optional
        Arguments of `reduce` that go before those of the document: solver, cache, progress.
    """

    def __init__(
        self,
        document: Document,
        broken: Iterable[tuple[str, str | None]] = (),
        *,
        rigid: bool = False,
        trust: bool = False,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        self.options = dict(options or {})
        self.document = document
        self.trust = trust
        self.broken = set(broken)
        self.rigid = rigid
        self.found: list[tuple[Loc, Problem]] = []
        self.noted: set[Problem] = set()
        self.warnings: dict[str, None] = {}  # in their order
        self.events: dict[str, Any] = {}
        self.curves: dict[str, Any] = {}
        self.late_events: set[str] = set()
        self.forms = {**FORMS, **OF_FORCES, **OF_SENSORS}
        self.sensors: list[str] = []  # names of all sensors of the file

    # -- placing problems -------------------------------------------------------------------

    def note(self, loc: Loc, message: str) -> None:
        """Note a problem at a place of the document."""
        problem = Problem(self.document.where(loc), message)
        if problem not in self.noted:
            self.noted.add(problem)
            self.found.append((loc, problem))

    def make(self, loc: Loc, make: Callable[..., T], /, *args: Any, **kwargs: Any) -> T | None:
        """Return ``make(*args, **kwargs)``; None with the problems noted if it fails."""
        own = {str(loc[-1]).lower() if loc else "", make.__name__.lower(), make.__qualname__}
        name = kwargs.get("name", args[0] if args else kwargs.get("coordinate"))
        name = getattr(name, "name", name)
        result, errors = None, None
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                result = make(*args, **kwargs)
            except InputError as error:
                errors = error
        # outside of the block, or what is passed on would be caught again without end
        for item in caught:
            self.warn(loc, item, own, name)
        for problem in errors.problems if errors else ():
            message = shorten(problem.where, problem.message, own, name)
            place = self.refine(loc, problem.message)
            self.note(place, message.removeprefix(f"{place[-1]}: " if place else ""))
        return result

    def warn(
        self, loc: Loc, item: warnings.WarningMessage, own: set[str], name: Any = None
    ) -> None:
        """Keep a warning with its place, pass on those that are not jousto's."""
        if not issubclass(item.category, JoustoWarning):
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)
            return
        where, colon, message = str(item.message).partition(": ")
        if colon:
            message = shorten(where, message, own, name)
        place = self.refine(loc, message)
        message = message.removeprefix(f"{place[-1]}: " if place else "")
        text = f"{self.document.where(place)}: {message if colon else where}"
        self.warnings[text] = None

    def refine(self, loc: Loc, message: str) -> Loc:
        """Return the path of the field that a message of a constructor begins with."""
        for word in re.findall(r"[A-Za-z_]\w*", message)[:4]:
            if (*loc, word) in self.document.lines:
                return (*loc, word)
        return loc

    # -- parts ------------------------------------------------------------------------------

    def part_name(self, loc: Loc, name: Any) -> bool:
        """Return whether a part may have this name, which becomes that of a file; note if not."""
        problems = Problems()
        check_name(problems, "part", name)
        for problem in problems.found:
            self.note(loc, problem.message)
        return not problems.found

    def file(self, name: str) -> Path:
        """Return a file name of the document, relative to the document's folder."""
        return self.document.folder / name

    def reduced(self, loc: Loc, name: str, entry: Any) -> Any:
        """Return the ReducedPart of an entry of parts, None if anything is wrong with it."""
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

    def method(self, loc: Loc, entry: Any, part: Any = None) -> Any:
        """Return the CraigBampton or FreeFree of an entry, None if it is wrong."""
        from jousto.reduction.methods import CraigBampton, FreeFree

        craig = isinstance(entry.reduce, sp.CraigBamptonEntry)
        kind: Any = CraigBampton if craig else FreeFree
        values = entry.reduce.given()
        if craig:
            values.setdefault("interfaces", ())
        if "residuals" in values:
            values["residuals"] = self.residuals((*loc, "reduce", "residuals"), entry, part)
        return self.make((*loc, "reduce"), kind, **values)

    def residuals(self, loc: Loc, entry: Any, part: Any) -> tuple[Any, ...]:
        """Return load patterns (ndof,) and names of stress sites; note sets that do not exist."""
        found: list[Any] = []
        for i, item in enumerate(entry.reduce.residuals):
            if isinstance(item, str):
                found.append(item)
            elif part is not None and isinstance(item, sp.PressurePatternEntry):
                from jousto.parts.loads import Pressure

                here = (*loc, i, "pressure")
                found.append(self.make(here, part.load, Pressure(item.pressure, 1.0)))
            elif part is not None:
                if item.nodes not in part.node_sets:
                    known = suggest(item.nodes, part.node_sets)
                    self.note((*loc, i, "nodes"), f"no set {item.nodes!r}{known}")
                    continue
                nodes = np.asarray(part.node_sets[item.nodes])
                pattern = np.zeros((len(part.nodes), part.dofs_per_node))
                pattern[nodes, :3] = np.asarray(item.force) / len(nodes)
                found.append(pattern.ravel())
        return tuple(item for item in found if item is not None)

    def reduction(self, loc: Loc, entry: Any, part: Any, method: Any) -> Any:
        """Return the ReducedPart of a part as the entry asks for, None if anything is wrong."""
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
        """Return the Part of an entry with a mesh, None if anything is wrong with it."""
        from jousto.parts.part import Part

        if isinstance(entry, sp.MatricesEntry):
            return build_matrices(self, loc, name, entry)
        if isinstance(entry, SolidEntry):
            return build_solid(self, loc, name, entry)
        before = len(self.found)
        values = entry.given("reduce", "in_plane", "keep", "stiffening", "residual_stress")
        self.beams(loc, values)
        makers: dict[Any, Any] = {
            sp.BeamEntry: Part.beam,
            sp.MembersEntry: Part.from_members,
            sp.FrameEntry: Part.frame,
        }
        make = makers[type(entry)]
        if len(self.found) > before:
            return None
        return self.make(loc, make, **values, name=name)

    def beams(self, loc: Loc, values: dict[str, Any]) -> None:
        """Replace the entries in the arguments of a part made of beams by objects."""
        from jousto.parts.mass import PointMass

        for key, value in values.items():
            here = (*loc, key)
            if key in ("section", "sections"):
                values[key] = self.each(here, value, self.section)
            elif key in ("material", "materials"):
                values[key] = self.each(here, value, self.material)
            elif key == "theory":
                values[key] = build_declared(self, here, value)
            elif key == "point_masses":
                values[key] = self.each(
                    here, value, lambda at, e: self.make(at, PointMass, **e.given())
                )
            elif key == "members":
                values[key] = self.each(here, value, self.member)

    def each(self, loc: Loc, value: Any, build: Callable[[Loc, Any], Any]) -> Any:
        """Return the object of an entry, or the list of objects of a list of entries."""
        if isinstance(value, Entry | str):
            return build(loc, value)
        return [build((*loc, i), item) for i, item in enumerate(value)]

    def material(self, loc: Loc, entry: Any) -> Any:
        """Return the material of an entry or of a name in the library."""
        from jousto.materials.library import material

        if isinstance(entry, str):
            return self.make(loc, material, entry)
        return build_declared(self, loc, entry)

    def section(self, loc: Loc, entry: Any) -> Any:
        """Return the cross section of an entry."""
        return build_declared(self, loc, entry)

    def member(self, loc: Loc, entry: sp.MemberEntry) -> Any:
        """Return the Member of an entry."""
        from jousto.parts.frames.members import Member

        values = entry.given()
        self.beams(loc, values)
        if values["section"] is None or values["material"] is None:
            return None
        return self.make(loc, Member, **values)

    # -- mechanism --------------------------------------------------------------------------

    def body(self, loc: Loc, entry: Any, parts: dict[str, Any]) -> Any:
        """Return the body of an entry, None if anything is wrong with it."""
        if isinstance(entry, BeamBodyEntry):
            return build_beam(self, loc, entry)
        values = self.orientations(loc, entry.given("part"))
        if isinstance(entry, sm.RigidBodyEntry):
            return self.make(loc, RigidBody, **values)
        if isinstance(entry, sm.ShapedEntry):
            return self.shaped(loc, entry, values)
        if isinstance(entry.damping, sm.RayleighEntry):
            from jousto.reduction.damping import Rayleigh

            values["damping"] = self.make((*loc, "damping"), Rayleigh, **entry.damping.given())
        reduced = parts.get(entry.part)
        if reduced is None:
            self.unknown((*loc, "part"), "parts", "part", entry.part, parts)
        if reduced is None or ("damping" in values and values["damping"] is None):
            return None
        if self.rigid:
            return self.make(loc, rigid_body, reduced=reduced, **values)
        return self.make(loc, FlexibleBody, reduced=reduced, **values)

    def shaped(self, loc: Loc, entry: sm.ShapedEntry, values: dict[str, Any]) -> Any:
        """Return the rigid body of a shape, None if anything is wrong with it."""
        makers: dict[type, Callable[..., Any]] = {
            sm.BoxBodyEntry: RigidBody.box,
            sm.CylinderBodyEntry: RigidBody.cylinder,
            sm.SphereBodyEntry: RigidBody.sphere,
            sm.MeshBodyEntry: RigidBody.from_mesh,
        }
        if isinstance(entry, sm.MeshBodyEntry):
            values["surface"] = self.file(values.pop("file"))
        return self.make(loc, makers[type(entry)], **values)

    def orientations(self, loc: Loc, values: dict[str, Any]) -> dict[str, Any]:
        """Replace turns about an axis by `Rotate` objects."""
        for key in ("orientation", "axes"):
            if key in values:
                values[key] = self.orientation((*loc, key), values[key])
        return values

    def orientation(self, loc: Loc, entry: Any) -> Any:
        """Return an orientation; a turn about an axis becomes a `Rotate`."""
        if not isinstance(entry, RotateEntry):
            return entry
        return self.make(loc, Rotate, entry.axis, degrees=entry.angle_deg)

    def unknown(
        self, loc: Loc, section: str | tuple[str, ...], kind: str, name: str, known: Iterable[str]
    ) -> None:
        """Note a reference to nothing, unless it is to an entry that failed itself."""
        sections = (section,) if isinstance(section, str) else section
        if not {(s, n) for s in sections for n in (name, None)} & self.broken:
            hint = ""
            if len(self.found) < MOST_HINTS:  # looking for likely names takes its time
                broken = (str(n) for s, n in sorted(self.broken, key=str) if s in sections and n)
                hint = suggest(name, [*known, *broken])
            self.note(loc, f"no {kind} {name!r}{hint}")

    def marker(self, loc: Loc, entry: Any, bodies: Mapping[str, Any]) -> Any:
        """Return the marker of an entry, None if anything is wrong with it."""
        if isinstance(entry, MarkerEntry):
            name, point, place = entry.body, entry.point, (*loc, "body")
        else:
            name, _, point = entry.partition(".")
            place = loc
        body = ground if name == "ground" else bodies.get(name)
        if body is None:
            self.unknown(place, "bodies", "body", name, [*bodies, "ground"])
            return None
        marker: Any
        if isinstance(entry, MarkerEntry) and entry.at is not None:
            if isinstance(body, FlexibleBody):
                self.note((*loc, "at"), f"{name!r} is flexible, give point: and the name of a node")
                return None
            marker = self.make((*loc, "at"), body.at, entry.at)
        else:
            point_place = (*loc, "point") if isinstance(entry, MarkerEntry) else loc
            marker = self.make(point_place, body.__getitem__, point)
        if marker is None or not isinstance(entry, MarkerEntry) or entry.axes is None:
            return marker
        axes = self.orientations(loc, {"axes": entry.axes})["axes"]
        return None if axes is None else self.make((*loc, "axes"), marker.turned, axes)

    def event(self, loc: Loc, name: str) -> Any:
        """Return the event that switches a signal, None if there is none that can."""
        if name in self.late_events:
            self.note(
                loc,
                f"event {name!r} watches a force, a coupling or a signal and cannot switch one; "
                "let it watch a coordinate or the motion of a marker",
            )
        elif name not in self.events:
            self.unknown(loc, "events", "event", name, self.events)
        return self.events.get(name)

    def section_items(
        self, key: str, entries: Any, index: list[int], build: Callable[[Loc, Any], Any]
    ) -> list[tuple[Loc, Any]]:
        """Return the objects of a list of entries that could be built, with their paths."""
        items: list[tuple[Loc, Any]] = []
        for i, entry in zip(index, entries or (), strict=True):
            item = build((key, i), entry)
            if item is None:
                self.broken.add((key, getattr(entry, "name", None)))
            else:
                items.append(((key, i), item))
        return items

    def mechanism(self, entry: sm.ModelEntry, index: dict[str, list[int]]) -> Any:
        """Return the Mechanism of a file; None if anything is wrong.

        Parameters
        ----------
        entry : ModelEntry
            The validated file, or what is left of it without invalid entries.
        index : dict
            For each list the places of its entries in the file.
        """
        parts: dict[str, Any] = {}
        for name, part in (entry.parts or {}).items():
            loc = ("parts", name)
            reduced = self.reduced(loc, name, part) if self.part_name(loc, name) else None
            if reduced is None:
                self.broken.add(("parts", name))
            else:
                parts[name] = reduced

        def named(items: list[tuple[Loc, Any]]) -> dict[str, Any]:
            return {item.name: item for _, item in items}

        def listed(
            key: str,
            build: Callable[[Loc, Any], Any],
            now: Callable[[Any], bool] = lambda e: True,
        ) -> list[tuple[Loc, Any]]:
            entries, places = getattr(entry, key) or (), index[key]
            # a rigid body has neither modes nor stress
            kept = [
                i
                for i, e in enumerate(entries)
                if now(e) and not (self.rigid and getattr(e.declared, "flexible", False))
            ]
            entries, places = [entries[i] for i in kept], [places[i] for i in kept]
            return self.section_items(key, entries, places, build)

        bodies = listed("bodies", lambda at, e: self.body(at, e, parts))
        by_name = named(bodies)
        made = {"bodies": by_name}
        joints = listed("joints", lambda at, e: build_declared(self, at, e, made))
        free = made["joints"] = named(joints)
        # sensors of bodies and joints, the events that watch them, then what events switch
        self.sensors = [e.name for e in entry.sensors or ()]
        late = {e.name for e in entry.sensors or () if is_late(e, free)}
        self.curves = build_curves(self, entry.fatigue)
        known = {"bodies": by_name, "joints": free, "couplings": {}, "forces": {}}
        known["curves"] = self.curves

        def sensed(now: Callable[[Any], bool]) -> list[tuple[Loc, Any]]:
            return listed("sensors", lambda at, e: build_declared(self, at, e, known), now)

        def watched(early: bool) -> list[tuple[Loc, Any]]:
            return listed(
                "events",
                lambda at, e: build_declared(self, at, e, known),
                lambda e: watches_late(e, late) != early,
            )

        sensors = sensed(lambda e: e.name not in late)
        known["sensors"] = named(sensors)
        events = watched(True)
        self.events = named(events)
        self.late_events = {e.name for e in entry.events or () if watches_late(e, late)}
        couplings = listed("couplings", lambda at, e: build_declared(self, at, e, made))
        loads = listed("forces", lambda at, e: build_declared(self, at, e, made))
        initial = listed("initial", lambda at, e: build_declared(self, at, e, made))
        frictions = listed("frictions", lambda at, e: build_declared(self, at, e, made))
        known |= {"couplings": named(couplings), "forces": named(loads)}
        known["frictions"] = named(frictions)
        stacked = ("damage", "bridge")
        sensors += sensed(lambda e: e.name in late and e.type not in stacked)
        known["sensors"] = named(sensors)
        sensors += sensed(lambda e: e.type == "bridge")
        known["sensors"] = named(sensors)
        measured = [e.name for e in entry.sensors or () if e.declared.flexible]
        sensors += sensed(  # what they count may be gone
            lambda e: e.type == "damage" and not (self.rigid and e.sensor in measured)
        )
        sensors.sort()
        known["sensors"] = named(sensors)
        events = sorted(events + watched(False))
        items = [*bodies, *joints, *couplings, *loads, *frictions, *initial, *sensors, *events]
        if not bodies and (self.found or self.broken):
            return None
        gravity = [] if entry.gravity is None else [Gravity(entry.gravity)]
        name = entry.name or "mechanism"
        return self.checked(items, gravity, name)

    def checked(self, items: list[tuple[Loc, Any]], gravity: list[Any], name: str) -> Any:
        """Return the Mechanism; note its problems at the entries they belong to."""
        from jousto.mechanism.mechanism import where

        places = {where(item): loc for loc, item in items}
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                made = Mechanism(
                    *(item for _, item in items),
                    *gravity,
                    name=name,
                )
            except InputError as error:
                for problem in error.problems:
                    loc = places.get(problem.where, ())
                    text = problem.message if loc else str(problem)
                    self.note(self.refine(loc, problem.message) if loc else loc, text)
                return None
        # what is broken would only cause wrong warnings
        if not (self.found or self.broken):
            for item in caught:
                text = str(item.message)
                place = next((p for p in places if text.startswith(f"{p}: ")), "")
                self.warn(places.get(place, ()), item, {place.lower()})
        return made


def rigid_body(name: str, *, reduced: Any, **values: Any) -> RigidBody:
    """Return the rigid body with mass, inertia and named nodes of a reduced part."""
    invariants = reduced.invariants
    mass, U = invariants.mass, invariants.second_moment
    center = invariants.first_moment / mass
    U = U - mass * np.outer(center, center)
    nodes = {key: reduced.nodes[m[0]] for key, m in reduced.node_sets.items() if len(m) == 1}
    pose = ("position", "orientation", "velocity", "angular_velocity")
    return RigidBody(
        name,
        mass,
        np.trace(U) * np.eye(3) - U,
        center=center,
        markers=nodes,
        **{key: values[key] for key in pose if key in values},
        outline=drawn_outline(reduced.nodes, reduced.elements),
    )


def drawn_outline(nodes: Any, elements: Any) -> Any:
    """Return the triangles (nt, 3, 3) of a solid, else a polyline along all elements."""
    if np.ndim(elements) == 2 and np.shape(elements)[1] == 3 and len(elements):
        return np.asarray(nodes)[np.asarray(elements)]
    return round_trip(nodes, elements)


def round_trip(nodes: Any, elements: Any) -> Any:
    """Return a polyline (k, 3) along all elements and back, None where there are none."""
    if np.ndim(elements) != 2 or not len(elements):
        return None
    neighbours: dict[int, list[int]] = {}
    for a, b in np.asarray(elements)[:, [0, -1]].tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    way, drawn, here = [int(elements[0][0])], set(), [int(elements[0][0])]
    while here:
        a = here[-1]
        ahead = [b for b in neighbours[a] if frozenset((a, b)) not in drawn]
        if ahead:
            drawn.add(frozenset((a, ahead[0])))
            here.append(ahead[0])
        else:
            here.pop()
        if here:
            way.append(here[-1])
    return np.asarray(nodes)[way]


def shorten(where: str, message: str, own: set[str], name: Any) -> str:
    """Return the sentence of a constructor without the name of the object it is about."""
    head = where.lower()
    if not where or head in own or head.endswith((f" {name!r}".lower(), f" '{name}'".lower())):
        return message
    return f"{where}: {message}"
