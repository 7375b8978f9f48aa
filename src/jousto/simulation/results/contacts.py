"""Contacts of a run: from touch to part, and the points that touch at an instant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar, overload

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count
from jousto.base.files import write_table
from jousto.base.object_repr import described
from jousto.model.contact_points import ContactPoint, points_of
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.simulation.results.contact_findings import contact_findings
from jousto.simulation.results.dataframes import frame_of
from jousto.simulation.state import State, put

T = TypeVar("T")
NEAR = 1e-9
"""Difference of two instants over the time up to which they are the same."""


@described
@dataclass(frozen=True)
class ContactEvent:
    """A contact from its touch to its part.

    Attributes
    ----------
    contact : str
        Name of the contact, or of the set.
    a, b : str
        Shapes of a set, or bodies: that is touched, and the other one.
    tip : int
        Number of the tip, for shapes with several tips.
    touch, part : float
        Instants, s; part is NaN for a contact that touches at the end of the run.
    approach, rebound : float
        Speed of approach at the touch, and speed at the part, m/s.
    force, depth : float
        Largest normal force, N, and depth, m.
    impulse, friction_impulse : float
        Impulse of the normal force, and integral of the size of the friction force, N s.
    lost_restitution, lost_friction : float
        Energy that the normal force and the friction have lost, J.
    steps : int
        Number of steps in which it touched.
    """

    contact: str
    a: str
    b: str
    tip: int
    touch: float
    part: float
    approach: float
    rebound: float
    force: float
    depth: float
    impulse: float
    friction_impulse: float
    lost_restitution: float
    lost_friction: float
    steps: int


EVENT_UNITS = dict(
    zip(
        (one.name for one in fields(ContactEvent)),
        ("", "", "", "1", "s", "s", "m/s", "m/s", "N", "m", "N s", "N s", "J", "J", "1"),
        strict=True,
    )
)
POINT_UNITS = {
    "contact": "",
    "a": "",
    "b": "",
    "tip": "1",
    "features": "",
    "phase": "",
    "gap": "m",
    "point": "m",
    "normal": "1",
    "force": "N",
    "friction": "N",
    "pressure": "Pa",
    "approach": "m/s",
    "age": "s",
    "stored": "J",
}


class _Listed(Sequence[T]):
    """Sequence of contacts that can be written as a table."""

    units: dict[str, str]

    def __init__(self, items: Sequence[T]) -> None:
        self._items = tuple(items)

    @overload
    def __getitem__(self, place: int) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[T]: ...
    def __getitem__(self, place: int | slice) -> T | Sequence[T]:
        return self._items[place]

    def __len__(self) -> int:
        return len(self._items)

    def _columns(self) -> dict[str, tuple[str, list[Any]]]:
        """Return unit and values of each column; vectors are three columns."""
        found: dict[str, tuple[str, list[Any]]] = {}
        for name, unit in self.units.items():
            values = [getattr(one, name) for one in self._items]
            if name in ("point", "normal", "friction"):
                for k, axis in enumerate("xyz"):
                    found[f"{name}.{axis}"] = unit, [float(value[k]) for value in values]
            else:
                found[name] = unit, values
        return found

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame`` with a row for each; needs the extra ``frames``.

        ``frame.attrs["units"]`` has the unit of each column.
        """
        return frame_of(self._columns())

    def to_csv(self, path: str | Path) -> Path:
        """Write a table of text with a row for each, and return its path."""
        columns = self._columns()
        head = [
            f"{name} ({unit})" if unit not in ("", "1") else name
            for name, (unit, _) in columns.items()
        ]
        values = [values for _, values in columns.values()]
        return write_table(path, head, zip(*values, strict=True))


class ContactPoints(_Listed[ContactPoint]):
    """Points at which bodies touch at an instant, a `ContactPoint` each.

    Attributes
    ----------
    time : float
        Instant, s.
    """

    units = POINT_UNITS

    def __init__(self, time: float, items: Sequence[ContactPoint]) -> None:
        super().__init__(items)
        self.time = time

    def __repr__(self) -> str:
        return f"<ContactPoints: {count(len(self), 'point')} at {self.time:g} s>"


class RunContacts(_Listed[ContactEvent]):
    """Contacts of a run in order of their ends, a `ContactEvent` each, and those of an instant.

    Attributes
    ----------
    dropped : int
        Number of further contacts, which are not kept.
    """

    units = EVENT_UNITS

    def __init__(self, run: Any, rows: Array, sources: dict[str, Any], dropped: int) -> None:
        pairs = pairs_of(sources)
        super().__init__([_event(row, pairs) for row in rows.tolist()])
        self._run = run
        self._pairs = [pairs(*map(int, row[:3])) for row in rows.tolist()]
        self.dropped = dropped

    def __repr__(self) -> str:
        more = f", {self.dropped} more not kept" if self.dropped else ""
        return f"<RunContacts: {count(len(self), 'contact')}{more}>"

    @property
    def findings(self) -> tuple[str, ...]:
        """What is wrong with the contacts of the run, with the remedy of each; see `doctor`."""
        return contact_findings(self, self._pairs, self._run)

    def at(self, time: float, *, near: bool = False, model: Model | None = None) -> ContactPoints:
        """Return the points at which bodies touch at a stored instant.

        They are computed from the stored state, exactly as during the run.

        Parameters
        ----------
        time : float
            A stored instant, s; negative for the last one.
        near : bool
            Whether also points that are near but do not touch are returned.
        model : Model, optional
            Compiled model, for results of a file.

        Raises
        ------
        InputError
            If no instant is stored at that time, or the model is needed.
        """
        model = model or self._run.model
        if model is None:
            raise InputError(
                Problem(
                    self._run.where,
                    "contains no compiled model, from which the contacts of an instant are "
                    "computed; give it: run.contacts.at(time, model=jo.compile(mechanism))",
                )
            )
        state = self._run.state(time)
        return ContactPoints(state.time, points_at(model, state, near=near))


def points_at(model: Model, state: State, *, near: bool = False) -> list[ContactPoint]:
    """Return the points at which bodies touch in a state; `near`: also those that are near."""
    if not model.touches:
        return []
    engine = Engine(model, implicit=False)
    put(engine, state, "contacts")
    return points_of(engine, near=near)


@dataclass(frozen=True)
class Pair:
    """Two shapes that touch: contact, a, b and tip, size of the smaller one, m, and restitution.

    Touches have the restitution where they approach faster than `slowest`, m/s; none if it is None.
    """

    words: tuple[str, str, str, int]
    thickness: float = 0.0
    restitution: float = 0.0
    slowest: float | None = 0.0


def pairs_of(sources: dict[str, Any]) -> Callable[[int, int, int], Pair]:
    """Return the function that gives the `Pair` of a force, a shape and the other shape."""
    single = {
        force: Pair((name, a, b, tip), *about)
        for force, name, tip, a, b, *about in sources["contacts"]
    }

    def of(force: int, on: int, other: int) -> Pair:
        if force in single:
            return single[force]
        for first, last, name, shapes, _, sizes, surfaces, *tables in sources["sets"]:
            if first <= force <= last and 0 <= min(on, other):
                thickness = min((x for x in (sizes[on], sizes[other]) if x > 0.0), default=0.0)
                asked = (table[surfaces[on]][surfaces[other]] for table in tables)
                return Pair((name, shapes[on], shapes[other], 0), thickness, *asked)
        return Pair((f"force {force}", str(on), str(other), 0))

    return of


def _event(row: list[Any], pairs: Callable[[int, int, int], Pair]) -> ContactEvent:
    force, on, of, *numbers, steps = row
    pair = pairs(int(force), int(on), int(of))
    values: list[Any] = [*pair.words, *numbers, int(steps)]
    return ContactEvent(*values)
