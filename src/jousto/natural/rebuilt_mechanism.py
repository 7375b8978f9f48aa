"""Copies of a mechanism with other parts: declared objects with replaced references."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.signals.base import Constant, Input
from jousto.reduction.frames.transfer import same_motion
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.state import State


class Exchange:
    """Copier of declared objects that replaces given objects, in all references.

    Parameters
    ----------
    new : mapping of int to object
        Replacement of an object, by the id of the old one.
    hold : bool
        Whether external inputs become constants of their initial values.
    """

    def __init__(self, new: Mapping[int, Any], *, hold: bool = False) -> None:
        self.new, self.hold = dict(new), hold
        self._kept: list[Any] = []  # references to old objects, so that their ids stay valid

    def __call__(self, old: Any) -> Any:
        """Return the copy of an object, or the object itself if it refers to no replaced one."""
        if id(old) not in self.new:
            self._kept.append(old)
            self.new[id(old)] = self._made(old)
        return self.new[id(old)]

    def _made(self, old: Any) -> Any:
        if self.hold and isinstance(old, Input):
            return Constant(old.initial)
        if isinstance(old, tuple | list):
            items = [self(item) for item in old]
            same = all(a is b for a, b in zip(items, old, strict=True))
            return old if same else type(old)(items)
        if isinstance(old, Declared):
            names = list(old.fields)
        elif isinstance(old, Marker) or (is_dataclass(old) and _refers(old)):
            names = [f.name for f in fields(old) if f.init]
        else:
            return old
        values = {name: getattr(old, name) for name in names}
        more = {name: self(value) for name, value in values.items()}
        changed = {name: value for name, value in more.items() if value is not values[name]}
        made: Any = old
        return replace(made, **changed) if changed else old


def _refers(old: Any) -> bool:
    """Return whether an object is an item of a mechanism or a container of items."""
    return type(old).__module__.startswith("jousto.mechanism.")


def with_constant_inputs(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with its external inputs replaced by their initial values."""
    return _exchanged(mechanism, Exchange({}, hold=True))


def with_parts(
    mechanism: Mechanism, parts: Mapping[FlexibleBody, ReducedPart], **more: Any
) -> Mechanism:
    """Return the mechanism with other reduced parts in some bodies, with the same initial motion.

    Parameters
    ----------
    mechanism : Mechanism
    parts : mapping of FlexibleBody to ReducedPart
        Reductions of the same part by modes that include the motion of the old ones.
    **more
        Further changed fields of these bodies.
    """
    new = {}
    for body, part in parts.items():
        q, v = same_motion(body.reduced, part, *_declared(body))
        new[id(body)] = replace(
            body,
            reduced=part,
            position=q[:3],
            orientation=q[3:7],
            modal_coordinates=q[7:],
            velocity=v[:3],
            angular_velocity=v[3:6],
            modal_velocities=v[6:],
            **more,
        )
    return _exchanged(mechanism, Exchange(new))


def _declared(body: FlexibleBody) -> tuple[Array, Array]:
    q = np.concatenate([body.position, body.orientation, body.modal_coordinates])
    v = np.concatenate([body.velocity, body.angular_velocity, body.modal_velocities])
    return q, v


def _exchanged(mechanism: Mechanism, change: Exchange) -> Mechanism:
    items = [change(item) for item in mechanism.items]
    if all(a is b for a, b in zip(items, mechanism.items, strict=True)):
        return mechanism
    return Mechanism(*items, name=mechanism.name, core=mechanism.core)


def transfer_state(state: State, old: Mechanism, new: Mechanism) -> State:
    """Return the state of a mechanism with other parts that equals a state of the old one.

    The states of controllers are copied; stick-slip states and revolution counters are not.
    """
    qs, vs = [], []
    iq = iv = 0
    for before, after in zip(old.bodies, new.bodies, strict=True):
        n = len(before.modal_coordinates)
        q, v = state.q[iq : iq + 7 + n], state.v[iv : iv + 6 + n]
        iq, iv = iq + 7 + n, iv + 6 + n
        if isinstance(before, FlexibleBody) and isinstance(after, FlexibleBody):
            if before.reduced is not after.reduced:
                q, v = same_motion(before.reduced, after.reduced, q, v)
        qs.append(q)
        vs.append(v)
    q, v = np.concatenate(qs), np.concatenate(vs)
    return State(q, v, state.lam, state.time, inputs=state.inputs, states=state.states)
