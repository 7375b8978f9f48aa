"""Points at which bodies touch, for the arrows of contact forces."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.model.compile import compile
from jousto.model.contact_points import ContactPoint, points_of
from jousto.model.native.native import Engine
from jousto.schema.read import parse_model
from jousto.simulation.results.row_layout import Column
from jousto.simulation.state import MEMORY, State, put

if TYPE_CHECKING:
    from jousto.model.model import Model
    from jousto.simulation.results.solution import Solution

MOST_ARROWS = 2000
"""Largest number of points of an instant; the largest forces are taken."""
WIDTH = 13
"""Numbers of a point: place (3,), force on b (3,), gap, normal force, friction, pressure, speed of
approach, age, and the index of its text."""


class Touches:
    """Points at which the bodies of a model touch in given states.

    Examples
    --------
    >>> import jousto as jo
    >>> from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere
    >>> ball = jo.RigidBody.sphere("ball", radius=0.1, mass=2.0, position=(0, 0, 0.099))
    >>> floor = Contact("floor", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(0.1),
    ...                 PowerLaw(1e4, 1.0))
    >>> model = jo.compile(jo.Mechanism(ball, floor))
    >>> found = Touches(model).at([State(model.q0, model.v0, [])])
    >>> found["texts"], found["values"][0, 5].round(6).item()
    (['floor: ground - ball, no friction'], 10.0)
    """

    def __init__(self, model: Model) -> None:
        self._engine = Engine(model, implicit=False)
        self._one = threading.Lock()

    def at(self, states: Iterable[State]) -> dict[str, Any]:
        """Return the points of each state: how many, their numbers (k, `WIDTH`) and their texts."""
        with self._one:
            found = [self._points(state) for state in states]
        return packed(found)

    def _points(self, state: State) -> list[ContactPoint]:
        put(self._engine, state, "contacts")
        return points_of(self._engine)


def packed(found: Sequence[Sequence[ContactPoint]]) -> dict[str, Any]:
    """Return points of instants as arrays, for `Touches.at`."""
    texts: dict[str, int] = {}
    rows: list[list[float]] = []
    counts = []
    for points in found:
        kept = sorted(points, key=lambda one: -one.force)[:MOST_ARROWS]
        counts.append(len(kept))
        for one in kept:
            rubbed = float(np.linalg.norm(one.friction))
            numbers = (one.gap, one.force, rubbed, one.pressure, one.approach, one.age)
            text = texts.setdefault(text_of(one), len(texts))
            force = one.force * one.normal + one.friction
            rows.append([*one.point, *force, *numbers, text])
    return {
        "kind": "touches",
        "counts": np.array(counts, dtype=np.uint32),
        "values": np.array(rows, dtype=np.float64).reshape(-1, WIDTH),
        "texts": list(texts),
    }


def text_of(one: ContactPoint) -> str:
    """Return contact, pair, features and phase in a line: ``feet: floor - pad 2, sticks``."""
    tip = f" {one.tip}" if one.tip and not one.features else ""
    features = f" ({one.features})" if one.features else ""
    return f"{one.contact}: {one.a} - {one.b}{tip}{features}, {one.phase}"


def state_of_row(row: Array, known: dict[str, Column]) -> State:
    """Return the state in a row of the engine of a running machine."""

    def values(place: str) -> Array:
        column = known[place]
        return row[column.first : column.first + column.count]

    memory: dict[str, Any] = {
        name: values(f"state/{name}")
        for name in MEMORY
        if name != "input" and f"state/{name}" in known
    }
    return State(
        q=values("state/q"),
        v=values("state/v"),
        lam=values("state/multipliers"),
        time=float(values("time")[0]),
        **memory,
    )


def model_of(run: Solution) -> Model:
    """Return the compiled model of a run: its own, or that of the text in its file.

    Code that the text names does not run.

    Raises
    ------
    InputError
        If the file contains no text, or the model in it cannot be made here.
    """
    if run.model is not None:
        return run.model
    where = Path(run.where)
    if not run.model_text.strip():
        message = (
            "contains no model, from which forces of contacts are computed: it was made in Python; "
            "there jo.view(run) shows them"
        )
        raise InputError(Problem(where.name, message))
    text = parse_model(run.model_text, name=f"model in {where.name}", folder=where.resolve().parent)
    return compile(text.mechanism)
