"""Drag spring: a spring and damper that pulls a point of a body towards a target.

``F = k (x - r) - c r'`` acts at the point r, which may be anywhere on a body; its modal forces
follow from the mode shapes at the point. It consists of three forces of the engine along the axes
of the world frame, whose references x are external inputs, so that the energy balance includes its
work. Body and point are inputs too, so that a record of the inputs contains the whole drag.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.rotations import rotation_matrix
from jousto.model.model import (
    CoordinateModel,
    ForceModel,
    MarkerModel,
    Model,
    SensorModel,
    Shape,
    SignalModel,
)
from jousto.model.native.header import packed
from jousto.model.native.native import Engine
from jousto.simulation.state import State, put

TARGET = ("hand x", "hand y", "hand z")  # m, world frame
BODY = "hand body"  # index of the body, -1 for none
POINT = ("hand point x", "hand point y", "hand point z")  # m, body frame, undeformed
LAW = ("hand stiffness", "hand damping")  # inputs of stiffness, N/m, and damping, N s/m
NAMES = (*TARGET, BODY, *POINT, *LAW)
IN_FRAMES = (
    *("position", "velocity", "acceleration", "acceleration parts"),
    *("orientation", "angular velocity", "angular acceleration"),
)
"""Kinds of sensors whose objects and observers are indices of frames."""
FREQUENCY = 1.5  # natural frequency of a free mass on the drag spring, Hz of real time
DAMPING = 0.7  # damping ratio of this mass
REACH = 0.2  # largest omega times step, so that the methods integrate the drag spring accurately


@dataclass(frozen=True)
class Grip:
    """Point of a body to which the drag spring is attached, with stiffness and damping.

    Attributes
    ----------
    body : int
        Index of the body in the model.
    point : tuple of 3 floats
        Undeformed position in the body frame, m.
    stiffness, damping : float
        k in N/m and c in N s/m.
    """

    body: int
    point: tuple[float, float, float]
    stiffness: float
    damping: float

    @property
    def inputs(self) -> dict[str, float]:
        """Values of the inputs that describe this grip, by name."""
        values = (float(self.body), *self.point, self.stiffness, self.damping)
        return dict(zip((BODY, *POINT, *LAW), values, strict=True))

    @staticmethod
    def of(inputs: Mapping[str, float]) -> Grip | None:
        """Return the grip described by inputs; None if the drag spring is detached."""
        if inputs[BODY] < 0:
            return None
        x, y, z = (inputs[name] for name in POINT)
        return Grip(int(inputs[BODY]), (x, y, z), *(inputs[name] for name in LAW))


def with_hand(model: Model) -> Model:
    """Return the model with a detached drag spring: two frames, three forces, inputs `NAMES`.

    Raises
    ------
    InputError
        If the model has inputs of these names.
    """
    problems = Problems()
    for name in sorted(set(NAMES) & set(model.inputs)):
        problems.add(f"input {name!r}", "is reserved for the drag spring; choose another name")
    problems.raise_if_any()
    first, here = len(model.signals), model.active
    ground = MarkerModel(-1, True, np.zeros(3), np.eye(3), None, None)
    count = len(model.inputs)
    signals = tuple(
        SignalModel("input", np.array([-1.0 if name == BODY else 0.0]), count + i, name=name)
        for i, name in enumerate(NAMES)
    )
    along = len(model.coordinates)
    made = replace(
        model,
        # the frames of sensors are the last ones
        markers=(
            *model.markers[:here],
            ground,
            replace(ground, turns=False),
            *model.markers[here:],
        ),
        active=here + 2,
        sensors=tuple(_moved(sensor, here) for sensor in model.sensors),
        signals=(*model.signals, *signals),
        coordinates=(
            *model.coordinates,
            *(CoordinateModel(TARGET[k], "along", here, here + 1, k) for k in range(3)),
        ),
        forces=(
            *model.forces,
            *(
                ForceModel(
                    TARGET[k],
                    "along",
                    _law(0.0, 0.0),
                    coordinate=along + k,
                    active=True,
                    reference=first + k,
                )
                for k in range(3)
            ),
        ),
    )
    return made.keeping_tree(model)


def _law(stiffness: float, damping: float) -> Array:
    return packed(
        "jo_along_data", stiffness=stiffness, damping=damping, free=0.0, preload=0.0, limit=0.0
    )


def _moved(sensor: SensorModel, first: int) -> SensorModel:
    """Return a sensor with its frame indices from `first` on increased by two."""

    def place(frame: int) -> int:
        return frame + 2 if frame >= first else frame

    if sensor.kind in IN_FRAMES:
        sensor = replace(sensor, object=place(sensor.object), other=place(sensor.other))
    return replace(sensor, frame=place(sensor.frame))


def with_grip(model: Model, grip: Grip | None) -> Model:
    """Return a model `with_hand` with the drag spring attached to a grip, or detached for None."""
    here = model.active - 1
    if grip is None:
        marker = MarkerModel(-1, False, np.zeros(3), np.eye(3), None, None)
        law = _law(0.0, 0.0)
    else:
        Phi = shapes_at(model.shapes[grip.body], np.array(grip.point))
        marker = MarkerModel(
            grip.body, False, np.array(grip.point), np.eye(3), Phi if Phi.size else None, None
        )
        law = _law(grip.stiffness, grip.damping)
    forces = (*model.forces[:-3], *(replace(force, data=law) for force in model.forces[-3:]))
    markers = (*model.markers[:here], marker, *model.markers[here + 1 :])
    return replace(model, markers=markers, forces=forces).keeping_tree(model)


def shapes_at(shape: Shape, point: Array) -> Array:
    """Return the mode shapes Phi (3, n) at the point of the body nearest to a point.

    On lines and triangles the shapes are interpolated linearly between the nodes.
    """
    if not shape.modes.shape[2]:
        return np.zeros((3, 0))
    nearest = int(np.argmin(np.sum((shape.nodes - point) ** 2, axis=1)))
    best, shares = np.inf, {nearest: 1.0}
    if shape.elements.ndim == 2 and shape.elements.shape[1] in (2, 3):
        for element in shape.elements[np.any(shape.elements == nearest, axis=1)]:
            found = _shares(shape.nodes[element], point)
            away = float(np.sum((found @ shape.nodes[element] - point) ** 2))
            if away < best:
                best, shares = away, dict(zip(map(int, element), found, strict=True))
    places, weights = list(shares), np.array(list(shares.values()))
    Phi: Array = np.tensordot(weights, shape.modes[places], axes=1)
    return Phi


def _shares(corners: Array, point: Array) -> Array:
    """Return barycentric weights of the point of a line or triangle nearest to a point."""
    edges = corners[1:] - corners[0]
    inside, *_ = np.linalg.lstsq(edges.T, point - corners[0], rcond=None)
    shares = np.array([1.0 - inside.sum(), *inside])
    if (shares >= 0.0).all():
        return shares
    if len(corners) == 2:
        ends: Array = np.clip(shares, 0.0, 1.0)
        return ends
    best, found = np.inf, shares
    for k in range(3):  # the nearest point is on an edge
        two = [i for i in range(3) if i != k]
        on = np.zeros(3)
        on[two] = _shares(corners[two], point)
        away = float(np.sum((on @ corners - point) ** 2))
        if away < best:
            best, found = away, on
    return found


def point_position(model: Model, q: Array, body: int, point: Array) -> Array:
    """Return the position of a point of a body, ``R + A (u0 + Phi p)``, m, world frame."""
    b = model.bodies[body]
    u = point + shapes_at(model.shapes[body], point) @ q[b.iq + 7 : b.iq + 7 + b.n]
    return np.asarray(q[b.iq : b.iq + 3] + rotation_matrix(q[b.iq + 3 : b.iq + 7]) @ u)


def mobility(model: Model, state: State, body: int, point: Array) -> Array:
    """Return the inverse effective mass W (3, 3) of a point, ``W = J M^-1 J^T``, 1/kg.

    A force F at the point changes its acceleration by W F, in the world frame, with all joints and
    modes of the machine in its current state.
    """
    grip = Grip(body, (float(point[0]), float(point[1]), float(point[2])), 1.0, 0.0)
    engine = Engine(with_grip(model, grip))
    put(engine, state, "hand")
    b, r = model.bodies[body], point_position(model, state.q, body, point)
    A = rotation_matrix(state.q[b.iq + 3 : b.iq + 7])
    Phi, u = shapes_at(model.shapes[body], point), A.T @ (r - state.q[b.iq : b.iq + 3])
    places = [model.inputs.index(name) for name in TARGET]
    found = []
    for force in (np.zeros(3), *np.eye(3)):
        engine.input[places] = r + force
        engine.restart()
        a = engine.accelerations()[0][b.iv : b.iv + 6 + b.n].copy()
        found.append(a[:3] + A @ (np.cross(a[3:6], u) + Phi @ a[6:]))
    return np.stack([a - found[0] for a in found[1:]], axis=1)


def grip_at(
    model: Model, state: State, body: int, point: Array, *, step: float, speed: float = 1.0
) -> Grip:
    """Return a grip whose stiffness and damping fit the effective mass of the point.

    ``k = m omega^2``, ``c = 1.4 m omega`` with the smallest effective mass m of the point over all
    directions and omega of 1.5 Hz of real time, which is stable at the step of the method.

    Parameters
    ----------
    model : Model
        From `with_hand`.
    state : State
        Current state of the machine.
    body : int
        Index of the body.
    point : (3,) array
        Undeformed position in the body frame, m.
    step : float
        Step of the method, s.
    speed : float
        Simulated seconds per second of real time; 0 is treated as 1.

    Raises
    ------
    InputError
        If there is no such body.
    """
    if not 0 <= body < len(model.bodies):
        raise InputError(
            Problem("pull", f"body {body} does not exist; there are {len(model.bodies)}")
        )
    W = mobility(model, state, body, point)
    most = float(np.linalg.eigvalsh(0.5 * (W + W.T))[-1])
    mass = sum(float(b.mass[0]) for b in model.bodies)
    mass = mass if most * mass <= 1.0 else 1.0 / most  # lower bound on W of a fixed point
    omega = min(2.0 * np.pi * FREQUENCY / (speed or 1.0), REACH / step)
    x, y, z = map(float, point)
    return Grip(body, (x, y, z), mass * omega**2, 2.0 * DAMPING * mass * omega)
