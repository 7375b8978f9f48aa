"""Builder: resolves the names of a document, such as those of markers, and collects problems."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from jousto.base.declare import Declared
from jousto.base.errors import InputError, JoustoWarning, Problem, suggest
from jousto.base.rotations import Rotate
from jousto.mechanism.bodies.body import ground
from jousto.schema.entries.base import Entry, EulerEntry, MarkerEntry, RotateEntry
from jousto.schema.file.document import Document, Loc

T = TypeVar("T")
MOST_HINTS = 100  # number of problems of a file that get a suggested name


class Builder:
    """Builder of the objects of one document; collects problems with their lines.

    Parameters
    ----------
    document : Document
        The document, with its lines and the folder of its files.
    broken : iterable of (str, str or None)
        Sections and names of entries that failed before; references to them are not reported
        again. None stands for any name.
    rigid : bool
        Whether flexible bodies become rigid.
    trust : bool
        Whether Python code and mock-up units that the document names may run.
    options : mapping, optional
        Arguments of `reduce` with precedence over those of the document: solver, cache, progress.
    """

    forms: Mapping[str, Callable[[Any, Any], Any]] = {}
    """How more forms become objects than those of every declared class."""

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
        self.warnings: dict[str, None] = {}  # warnings in the order of their occurrence
        # warnings caught in the current block; None outside of it
        self.caught: list[warnings.WarningMessage] | None = None
        self.foreign: list[warnings.WarningMessage] = []  # warnings of other libraries
        self.curves: dict[str, Any] = {}
        # objects that entries may refer to, by section
        self.known: dict[str, Mapping[str, Any]] = {}
        self.sensors: list[str] = []  # names of all sensors of the file
        self.kept: dict[Any, Any] = {}  # reduced parts of variants of the file

    @contextmanager
    def catching(self) -> Iterator[None]:
        """Catch the warnings of constructors; issue those of other libraries at the end."""
        try:
            with warnings.catch_warnings(record=True) as self.caught:
                warnings.simplefilter("always")
                yield
        finally:
            self.caught = None
        # outside of the block, where the warnings are not caught again
        foreign, self.foreign = self.foreign, []
        for item in foreign:
            warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)

    def note(self, loc: Loc, message: str) -> None:
        """Add a problem at a path of the document."""
        problem = Problem(self.document.where(loc), self.document.told(loc, message))
        if problem not in self.noted:
            self.noted.add(problem)
            self.found.append((loc, problem))

    def make(self, loc: Loc, make: Callable[..., T], /, *args: Any, **kwargs: Any) -> T | None:
        """Return ``make(*args, **kwargs)``; None, with its problems, if it raises InputError."""
        if self.caught is None:
            with self.catching():
                return self.make(loc, make, *args, **kwargs)
        result, errors = None, None
        before = len(self.caught)
        try:
            result = make(*args, **kwargs)
            if isinstance(result, Declared):
                result = result.made
        except InputError as error:
            errors = error
        if len(self.caught) == before and errors is None:
            return result
        caught, self.caught[before:] = self.caught[before:], []
        own = {
            str(loc[-1]).lower() if loc else "",
            make.__name__.lower(),
            make.__qualname__.lower(),
        }
        name = kwargs.get("name", args[0] if args else kwargs.get("coordinate"))
        name = getattr(name, "name", name)
        for item in caught:
            self.warn(loc, item, own, name)
        for problem in errors.problems if errors else ():
            head = headline(problem.where, own, name)
            self.note_problem(loc, problem, head)
        return result

    def note_problem(self, loc: Loc, problem: Problem, head: str = "") -> None:
        """Add a problem of the object of an entry, at the field concerned.

        Parameters
        ----------
        loc : tuple
            Path of the entry.
        problem : Problem
        head : str
            Text before its message.
        """
        place = self.field(loc, problem.path)
        message = problem.sentence if place == loc else problem.message
        self.note(place, f"{head}{message}")

    def warn(
        self, loc: Loc, item: warnings.WarningMessage, own: set[str], name: Any = None
    ) -> None:
        """Store a warning with its path; warnings of other libraries are issued later."""
        if not issubclass(item.category, JoustoWarning):
            self.foreign.append(item)
            return
        warning: Any = item.message
        place = self.field(loc, warning.path)
        own = {*own, *map(str, warning.path)}
        message = f"{headline(warning.where, own, name)}{warning.message}"
        self.warnings[f"{self.document.where(place)}: {message}"] = None

    def field(self, loc: Loc, path: Loc) -> Loc:
        """Return the path of a field of an entry, as far as the document contains it."""
        while path and (*loc, *path) not in self.document.lines:
            path = path[:-1]
        return (*loc, *path)

    def file(self, name: str) -> Path:
        """Return the path of a file that the document names, relative to the document's folder."""
        return self.document.folder / name

    def each(self, loc: Loc, value: Any, build: Callable[[Loc, Any], Any]) -> Any:
        """Return the object of an entry, or the list of objects of a list of entries."""
        if isinstance(value, Entry | str):
            return build(loc, value)
        return [build((*loc, i), item) for i, item in enumerate(value)]

    def orientations(self, loc: Loc, values: dict[str, Any]) -> dict[str, Any]:
        """Replace rotations about axes by `Rotate` objects."""
        for key in ("orientation", "axes"):
            if key in values:
                values[key] = self.orientation((*loc, key), values[key])
        return values

    def orientation(self, loc: Loc, entry: Any) -> Any:
        """Return an orientation; rotations about axes become a `Rotate`."""
        if isinstance(entry, EulerEntry):
            return self.make(loc, Rotate.euler, entry.convention, degrees=entry.euler_deg)
        if not isinstance(entry, RotateEntry):
            return entry
        return self.make(loc, Rotate, entry.axis, degrees=entry.angle_deg)

    def unknown(
        self, loc: Loc, section: str | tuple[str, ...], kind: str, name: str, known: Iterable[str]
    ) -> None:
        """Add the problem of an unknown name, unless the entry of that name is itself invalid."""
        sections = (section,) if isinstance(section, str) else section
        if self.lost(name):
            return
        if not {(s, n) for s in sections for n in (name, None)} & self.broken:
            hint = ""
            if len(self.found) < MOST_HINTS:  # the search for similar names is slow
                broken = (str(n) for s, n in sorted(self.broken, key=str) if s in sections and n)
                hint = suggest(name, [*known, *broken])
            self.note(loc, f"no {kind} {name!r}{hint}")

    def marker(self, loc: Loc, entry: Any, bodies: Mapping[str, Any]) -> Any:
        """Return the marker of an entry; None, with a problem, if it is invalid."""
        if isinstance(entry, MarkerEntry):
            name, point, place = entry.body, entry.point, (*loc, "body")
        else:
            name, _, point = entry.partition(".")
            place = loc
        body = ground if name == "ground" else bodies.get(name) or self.frame(name)
        if body is None:
            names = getattr(bodies, "names", bodies.keys)()  # names of frames included
            self.unknown(place, "bodies", "body", name, [*names, "ground"])
            return None
        marker: Any
        if isinstance(entry, MarkerEntry) and entry.at is not None:
            marker = self.make((*loc, "at"), body.at, entry.at)
        else:
            point_place = (*loc, "point") if isinstance(entry, MarkerEntry) else loc
            marker = self.make(point_place, body.__getitem__, point)
        if marker is None or not isinstance(entry, MarkerEntry) or entry.axes is None:
            return marker
        axes = self.orientations(loc, {"axes": entry.axes})["axes"]
        return None if axes is None else self.make((*loc, "axes"), marker.turned, axes)

    def lost(self, name: str) -> bool:
        """Return whether a name may belong to a robot that could not be built."""
        return False

    def frame(self, name: str) -> Any:
        """Return a named frame of a robot as a `RobotFrame`; None if there is no such frame."""
        return None

    def event(self, loc: Loc, name: str) -> Any:
        """Return the event that switches a signal; None, with a problem, if there is none."""
        events = self.known["events"]
        try:
            found = events.get(name)
        except CircleError:
            self.note(
                loc,
                f"event {name!r} watches a force, a coupling or a signal and cannot switch one; "
                "let it watch a coordinate or the motion of a marker",
            )
            return None
        if found is None:
            self.unknown(loc, "events", "event", name, events)
        return found


class CircleError(Exception):
    """Error of an entry that depends on itself."""


class Section(Mapping[str, Any]):
    """Objects of a section by name; each is built when it is first used.

    Parameters
    ----------
    builder : Builder
        Builder that collects problems, and the names of invalid entries.
    key : str
        Key of the section.
    entries : iterable of (name, path, entry)
        Entries of the section.
    build : function
        Returns the object of a path and an entry; None for an invalid entry.
    """

    def __init__(
        self,
        builder: Builder,
        key: str,
        entries: Iterable[tuple[str, Loc, Any]],
        build: Callable[[Loc, Any], Any],
    ) -> None:
        self.builder, self.key, self.build = builder, key, build
        self.entries = tuple(entries)
        self.places = {name: i for i, (name, _, _) in enumerate(self.entries)}
        self.made: dict[int, Any] = {}
        self.open: set[int] = set()  # keys of the objects under construction, to detect cycles

    def __getitem__(self, name: str) -> Any:
        """Return the object of a name; raise KeyError if there is none or it is invalid."""
        found = self.object(self.places[name])
        if found is None:
            raise KeyError(name)
        return found

    def __iter__(self) -> Iterator[str]:
        return (name for name, i in self.places.items() if self.made.get(i, i) is not None)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def entry(self, name: str) -> Any:
        """Return the entry of a name."""
        return self.entries[self.places[name]][2]

    def object(self, i: int) -> Any:
        """Return the object of an entry; None, with problems, if it is invalid."""
        if i in self.open:
            raise CircleError
        if i not in self.made:
            name, loc, entry = self.entries[i]
            self.open.add(i)
            try:
                self.made[i] = self.build(loc, entry)
            finally:
                self.open.remove(i)
            if self.made[i] is None:
                self.builder.broken.add((self.key, name))
        return self.made[i]

    def all(self) -> list[tuple[Loc, Any]]:
        """Return the objects of all valid entries, with their paths."""
        found = []
        for i, (name, loc, _) in enumerate(self.entries):
            try:
                item = self.object(i)
            except CircleError:
                self.builder.note(loc, f"{name!r} depends on itself")
                item = self.made[i] = None
            found.append((loc, item))
        return [(loc, item) for loc, item in found if item is not None]


def headline(where: str, own: set[str], name: Any) -> str:
    """Return the heading of a message of a constructor, without the name of the object itself."""
    head = where.lower()
    if not where or head in own or head.endswith((f" {name!r}".lower(), f" '{name}'".lower())):
        return ""
    return f"{where}: "
