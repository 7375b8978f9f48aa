"""Models of mechanisms that differ from a compiled one in numbers only."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.complexstep import floats, is_stepping
from jousto.base.garbage_collection import uncollected
from jousto.base.object_repr import described
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.event import Event
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.friction import Friction, Law
from jousto.mechanism.forces.gear_spring import GearLaw
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.initial import Initial
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.numbers import (
    Number,
    find_number,
    replaced,
    with_items,
    with_local_items,
)
from jousto.mechanism.signals.base import Signal
from jousto.model.compile import (
    compile,
    finish,
    pack,
    rigid_model,
    shape_of,
    warn_parts,
)
from jousto.model.likeness import Likeness
from jousto.model.mode_loads import mode_loads
from jousto.model.model import BodyModel, Model, SignalModel
from jousto.model.native.layout import lay_out_like
from jousto.model.packing.builder import friction_numbers, numbers_of
from jousto.model.sameness import Comparison
from jousto.model.symbol_record import Symbols, SymbolShape
from jousto.model.symbols import symbols

MOTION = frozenset({"velocity", "angular_velocity"})
RIGID = MOTION | {"mass", "inertia", "center"}
FLEXIBLE = MOTION | {"damping", "modal_damping", "modal_velocities"}

NUMERIC = (float, np.ndarray, type(None), Signal, Law, GearLaw)
"""Types of the fields of forces and friction that may differ."""

Changes = dict[int, tuple[Any, Any]]
"""Old and new items by the id of the old item."""


class _Structure(Exception):
    """Error of a change that is more than one of numbers."""


@described
class Variants:
    """A mechanism that is compiled once, and its variants with other numbers.

    Numbers of bodies (mass, inertia, centre of mass, damping, velocities), forces, signals of
    forces, friction, gravity, thresholds of events and initial coordinates are written into a copy
    of the compiled arrays and of the memory of the engine. Everything else, such as positions of
    joints or other parts, is compiled anew. The results are those of `compile` to the last bit.

    Parameters
    ----------
    mechanism : Mechanism
        The mechanism.
    core : str, optional
        Solver core as for `compile`.

    Attributes
    ----------
    mechanism : Mechanism
        The mechanism.
    model : Model
        Its compiled model.
    compilations : int
        Number of compilations so far, that of the mechanism included.

    Examples
    --------
    >>> import jousto as jo
    >>> rod = jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    >>> pivot = jo.Revolute("pivot", jo.ground["origin"], rod["origin"])
    >>> variants = Variants(jo.Mechanism(rod, pivot, jo.Gravity((0, -9.81, 0))))
    >>> heavier = variants.with_numbers({"rod.mass": 2.0, "gravity.y": -1.62})
    >>> float(heavier.bodies[0].mass[0]), variants.compilations
    (2.0, 1)
    """

    @explained
    def __init__(self, mechanism: Mechanism, *, core: str | None = None) -> None:
        self.mechanism = mechanism
        self._core = mechanism.core if core is None else core
        self.compilations = 1
        self._places: dict[str, Number] = {}
        self._flexible = any(isinstance(body, FlexibleBody) for body in mechanism.bodies)
        groups = mechanism.bodies, mechanism.frictions, mechanism.events
        self._indices = {id(x): i for items in groups for i, x in enumerate(items)}
        self._items = {id(item): item for item in mechanism.items}
        with uncollected():
            self._packed, self._builder = pack(mechanism)
            start = self._packed.q0.copy(), self._packed.v0.copy()
            closed: list[Model] = []
            self.model = finish(self._packed, self._builder, mechanism, self._core, keep=closed)
        self._like = Likeness(closed[0], self.model)
        self._packed = replace(self._packed, q0=start[0], v0=start[1])

    def _facts(self) -> str:
        return self.mechanism.name

    def number(self, name: str) -> Number:
        """Return a number of the mechanism by its address, see `find_number`."""
        if name not in self._places:
            self._places[name] = find_number(self.mechanism, name)
        return self._places[name]

    @explained
    def with_numbers(self, values: Mapping[str, Any]) -> Model:
        """Return the model with other numbers, for example ``{"rod.mass": 2.0}``.

        Parameters
        ----------
        values : dict
            Values in SI units by address, as for `jousto.mechanism.with_numbers`.

        Raises
        ------
        InputError
            If a number does not exist or is not allowed.
        """
        new = replaced([(self.number(name), value) for name, value in values.items()])
        changes = {key: (self._items[key], item) for key, item in new.items()}
        if self._is_local(changes):
            mechanism = with_local_items(self.mechanism, new)
            made = self._variant(changes, mechanism, lambda: with_items(self.mechanism, new))
            if made is not None:
                return made
        self.compilations += 1
        return compile(with_items(self.mechanism, new), core=self._core)

    def like(self, mechanism: Mechanism) -> Model | None:
        """Return the model of a mechanism of which only numbers differ; None if more differs."""
        changes = self._changes(mechanism)
        return None if changes is None else self._variant(changes, mechanism, lambda: mechanism)

    def _is_local(self, changes: Changes) -> bool:
        """Return whether no other item depends on the new numbers."""
        flexible = self._flexible
        for old, new in changes.values():
            keys = [key for key in old.fields if vars(old)[key] is not vars(new)[key]]
            if not may_differ(old, new, keys):
                return False
            if flexible and isinstance(old, RigidBody | FlexibleBody):
                return False  # loads on modes refer to the bodies
            if isinstance(old, RigidBody) and np.any(old.center != new.center):
                sites = [marker.site for marker in self._packed.markers]
                if any(s is not None and s.body is old and s.point == "center" for s in sites):
                    return False
        return True

    def _changes(self, mechanism: Mechanism) -> Changes | None:
        """Return the items of another mechanism that differ; None if more than numbers differ."""
        was = self.mechanism
        options = ("name", "core", "start")
        counts = ("bodies", "beams", "items")
        if any(getattr(was, key) != getattr(mechanism, key) for key in options) or any(
            len(getattr(was, key)) != len(getattr(mechanism, key)) for key in counts
        ):
            return None
        comparison = Comparison(was, mechanism)
        found: Changes = {}
        for a, b in zip(was.items, mechanism.items, strict=True):
            differ = comparison.differing(a, b)
            if differ is None or not may_differ(a, b, differ):
                return None
            if differ:
                found[id(a)] = (a, b)
        return found

    def _variant(
        self, changes: Changes, mechanism: Mechanism, whole: Callable[[], Mechanism]
    ) -> Model | None:
        """Return the model with changed items; None if it has to be compiled.

        Parameters
        ----------
        changes : dict
            Changed items.
        mechanism : Mechanism
            The mechanism with the new items.
        whole : function
            Function that returns it with all references, for drawing.
        """
        if is_stepping() or self.model.redundant:
            return None
        with uncollected():
            try:
                packed = self._repacked(changes, mechanism, whole)
            except _Structure:
                return None
            warn_parts(mechanism)
            vars(packed)["structure"] = self._like.closed
            lay_out_like(packed, self._like.closed)
            initials = tuple(
                _moved(now, was)
                for was, now in zip(self.mechanism.initials, mechanism.initials, strict=True)
            )
            options: Any = {"like": self._like, "initials": initials}
            return finish(packed, self._builder, mechanism, self._core, **options)

    def _repacked(
        self, changes: Changes, mechanism: Mechanism, whole: Callable[[], Mechanism]
    ) -> Model:
        was = self._packed
        new: dict[str, Any] = {"size": mechanism.size, "q0": was.q0.copy(), "v0": was.v0.copy()}
        lists: dict[str, list[Any]] = {}

        def change(group: str, place: int, made: Any) -> None:
            lists.setdefault(group, list(getattr(was, group)))[place] = made

        bodies = frictions = events = self._indices
        for key, (a, b) in changes.items():
            if isinstance(a, RigidBody | FlexibleBody):
                i = bodies[key]
                change("bodies", i, _body(was.bodies[i], b))
                _set_velocities(new["v0"], was.bodies[i], b)
                if isinstance(a, RigidBody) and np.any(a.center != b.center):
                    change("shapes", i, shape_of(b))
            elif isinstance(a, Gravity):
                new["gravity"] = np.array(floats(b.acceleration))
            elif isinstance(a, ForceElement):
                self._push(a, b, change)
            elif isinstance(a, Friction):
                i = frictions[key]
                if a.law.sticks != b.law.sticks:
                    raise _Structure
                change("frictions", i, replace(was.frictions[i], data=friction_numbers(b)))
            elif isinstance(a, Event):
                i = events[key]
                change("events", i, replace(was.events[i], threshold=b.threshold))
            elif not isinstance(a, Initial):
                raise _Structure
        new |= {group: tuple(made) for group, made in lists.items()}
        new["symbols"] = Symbols(was.name, lambda: _symbols(whole()))
        if self._flexible:
            new["mode_loads"] = mode_loads(mechanism)
        made = was.with_records(**new)
        if "signals" in lists and made.breaks.tobytes() != was.breaks.tobytes():
            raise _Structure
        return made

    def _push(self, a: ForceElement, b: ForceElement, change: Callable[..., None]) -> None:
        """Pack the laws of a force with other numbers."""
        if getattr(a, "sticks", False) or getattr(
            b, "sticks", False
        ):  # rows and friction beside it
            raise _Structure
        place = self._builder.force_places[id(a)]
        old, new = a.pushes, b.pushes
        if len(old) != len(new):
            raise _Structure
        for i, (was, now) in enumerate(zip(old, new, strict=True), place):
            model = self._packed.forces[i]
            if not _alike(was, now):
                raise _Structure
            data = numbers_of(now)
            if data.shape != model.data.shape:
                raise _Structure
            change("forces", i, replace(model, data=data, function=now.function))
            for name in ("signal", "reference", "spring", "damper"):
                self._signal(getattr(was, name), getattr(now, name), change)

    def _signal(self, a: Signal | None, b: Signal | None, change: Callable[..., None]) -> None:
        """Pack a signal with other numbers."""
        if a is b:
            return
        if a is None or b is None or type(a) is not type(b) or len(a.parts) != len(b.parts):
            raise _Structure
        for one, other in zip(a.parts, b.parts, strict=True):
            self._signal(one, other, change)
        was, now = a.law, b.law
        facts = ("kind", "count", "degree", "name")
        if any(getattr(was, key) != getattr(now, key) for key in facts):
            raise _Structure
        if a.parts:
            return
        i = self._builder.place_of(a)
        model: SignalModel = self._packed.signals[i]
        data = numbers_of(now)
        if data.tobytes() == model.data.tobytes():
            return
        if data.shape != model.data.shape or now.name:
            raise _Structure
        change("signals", i, replace(model, data=data))


def may_differ(was: Any, now: Any, keys: Iterable[str]) -> bool:
    """Return whether fields of an item may differ in a variant."""
    if isinstance(was, BeamNode):
        return not keys
    if isinstance(was, FlexibleBody):
        return FLEXIBLE.issuperset(keys)
    if isinstance(was, RigidBody):
        return RIGID.issuperset(keys)
    if isinstance(was, Event):
        return {"threshold"}.issuperset(keys)
    if not isinstance(was, (Gravity, ForceElement, Friction, Initial)):
        return not keys
    if isinstance(was, Initial) and (was.value is None) != (now.value is None):
        return False
    if isinstance(was, Initial) and (was.rate is None) != (now.rate is None):
        return False
    pairs = ((vars(was).get(key), vars(now).get(key)) for key in keys)
    return all(isinstance(a, NUMERIC) and isinstance(b, NUMERIC) for a, b in pairs)


def _alike(was: Push, now: Push) -> bool:
    """Return whether two laws differ in numbers only."""
    facts = ("kind", "turns", "follow", "active", "function", "states")
    if any(getattr(was, key) != getattr(now, key) for key in facts):
        return False
    ends = ("a", "b", "coordinate", "other", "body")
    return all((getattr(was, key) is None) == (getattr(now, key) is None) for key in ends)


def _moved(initial: Initial, was: Initial) -> Initial:
    """Return an initial value at the coordinate of another one, which the builder contains."""
    if initial.coordinate is was.coordinate:
        return initial
    made = copy.copy(initial)
    vars(made)["coordinate"] = was.coordinate
    return made


def _body(model: BodyModel, body: RigidBody | FlexibleBody) -> BodyModel:
    if isinstance(body, FlexibleBody):
        return replace(model, D=np.array(floats(body.modal_damping)))
    return rigid_model(body, model.iq, model.iv)


def _set_velocities(v: Any, model: BodyModel, body: RigidBody | FlexibleBody) -> None:
    """Set the velocities of a body in v (nv,)."""
    w = body.angular_velocity
    if w.any():
        w = rotation_matrix(body.orientation).T @ w
    v[model.iv : model.iv + 6 + model.n] = np.concatenate([body.velocity, w, body.modal_velocities])


def _symbols(mechanism: Mechanism) -> tuple[SymbolShape, ...]:
    """Return the symbols of a mechanism."""
    return symbols(mechanism, {id(body): i for i, body in enumerate(mechanism.bodies)})
