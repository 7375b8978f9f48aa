"""Balance: equations of a mechanism at rest or in steady rotation, over a parameter."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array, skew
from jousto.base.errors import Problems, suggest
from jousto.base.rotations import parse_direction, rotation_matrix
from jousto.model.model import ForceModel, Model
from jousto.model.native.native import IMAGINARY, Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.model.scales import velocity_metres
from jousto.simulation.contacts import contacts, slides_freely
from jousto.simulation.controllers import without_controllers
from jousto.simulation.modes.spectrum import blocks, newton_sparse
from jousto.simulation.state import State, put

LIGHT = 1e-12  # smallest mass, inertia or modal mass in the metric, over the largest of its kind
SOFT = 1e-10  # compliance added to redundant rows, over the largest compliance
FIXED = 1e-9  # residual of a rotation over the size, below which the joints allow it
GRAVITY, TIME, SPEED = "gravity", "time", "speed"
SMOOTH = ("contact", "contact track")
"""Contacts whose force is a function of the position; their first state is the phase."""
APART, CLOSED = 0, 1
"""Phases of a contact without friction."""


class Balance:
    """Equations of rest or of steady rotation, ``r(q, lam; s) = 0`` and ``C(q; s) = 0``.

    The residual ``r = M a + Cq^T lam - Q`` is that of the engine, with ``v = 0, a = 0``, or with
    the motion of a rotation of all bodies about a fixed axis: ``R' = W x (R - o)``, ``w = A^T W``,
    ``R'' = W x (W x (R - o))``, ``w' = 0``. Unknowns are increments [dR (world), dtheta (body
    frame), dp] of every body, then the multipliers. A rotation without a drive has one more row,
    which fixes the azimuth; its multiplier is the missing torque.

    Parameters
    ----------
    model : Model
    parameter : str
        Name of an input; "gravity" (a factor), "time" (s), or "speed" (rad/s) with an axis.
    state : State, optional
        First state; None: the initial state of the model.
    axis, point : (3,) arrays, optional
        Direction of the axis of a steady rotation and a point on it, m, world frame.
    speed : float
        Speed of the rotation, rad/s.
    frictionless : bool
        True omits stick-slip friction; False raises an error for it, also for that of contacts,
        since its force at rest is not unique.
    """

    def __init__(
        self,
        model: Any,
        parameter: str,
        state: State | None = None,
        *,
        axis: ArrayLike | None = None,
        point: ArrayLike = (0.0, 0.0, 0.0),
        speed: float = 0.0,
        where: str = "load_path",
        frictionless: bool = False,
    ) -> None:
        problems = Problems()
        if isinstance(model, Model):
            without_fmus(model, where, "has no state at rest that is known")
            without_controllers(model, where)
        kinds = [GRAVITY, TIME] + ([SPEED] if axis is not None else [])
        if not isinstance(model, Model):
            problems.add(where, f"model is a {type(model).__name__}, must be a Model from compile")
            problems.raise_if_any()
        if parameter not in model.inputs and parameter not in kinds:
            names = ", ".join([*model.inputs, *kinds])
            hint = suggest(parameter, [*model.inputs, *kinds]) or f"; there are: {names}"
            more = (
                ""
                if model.inputs
                else ": the model has no Input, so no load of it can be scaled; give a force or "
                "drive signal=jo.Input(name)"
            )
            problems.add(where, f"no parameter {parameter!r}{hint}{more}")
        if parameter == GRAVITY and GRAVITY not in model.inputs and not model.gravity.any():
            problems.add(where, "the mechanism has no gravity to scale; add jo.Gravity")
        for friction in model.frictions:
            if friction.sticks and not frictionless:
                problems.add(
                    f"friction '{friction.name}'",
                    "sticks and slips, so that the equilibrium is not unique; give it "
                    "law=Regularised()",
                )
        for force in contacts(model) if not frictionless else ():
            if why := _beside_a_path(force):
                problems.add(
                    f"contact '{force.name}'",
                    f"{why}; call equilibrium at each load, starting from the state before",
                )
        unit = None if axis is None else parse_direction(problems, where, "axis", axis)
        at = problems.array(where, "point", point, (3,))
        problems.raise_if_any()
        self.model, self.parameter = model, parameter
        self.kind = "input" if parameter in model.inputs else parameter
        self.engine = Engine(model)
        self._twin: Engine | None = None
        if state is not None:
            put(self.engine, state, where)
            if frictionless:
                self._let_go()
        self._may_touch = [] if frictionless else [f.state for f in contacts(model)]
        self._let_touch()
        self.engine.v[:] = 0.0
        self.engine.a[:] = 0.0
        self.axis = None if unit is None else np.array(unit / np.linalg.norm(unit), dtype=float)
        self.point = np.zeros(3) if at is None else np.array(at, dtype=float)
        self.speed = speed
        self._rate: Any = np.zeros(3)
        self.weights = _weights(model)
        self.gauge = self.axis is not None and self._turns_freely()

    def _let_go(self) -> None:
        """Release all joints that stick by friction; coordinates locked by events stay locked."""
        self.engine.slip[:] = 0
        self.engine.direction[:] = 0
        for friction in self.model.frictions:
            if friction.sticks:
                self.engine.locked[self.model.joints[friction.lock].lock] = 0

    def _let_touch(self) -> None:
        """Let every contact act wherever its shapes overlap.

        Then the force is a function of the position within an iteration as well, and contacts close
        and open on the path by themselves.
        """
        phases = self.engine.states[self._may_touch]
        self.engine.states[self._may_touch] = np.where(phases == APART, CLOSED, phases)

    # -- the parameter ------------------------------------------------------------------------

    @property
    def value(self) -> float:
        """Current value of the parameter; 0 for gravity."""
        if self.kind == "input":
            return float(self.engine.input[self.model.inputs.index(self.parameter)])
        if self.kind == TIME:
            return float(self.engine.time[0])
        return self.speed if self.kind == SPEED else 0.0

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return int(self.model.nv + self.model.nrow + self.gauge)

    def at(self, q: Any, lam: Any, value: Any, twin: bool = False) -> Engine:
        """Return the (complex) engine at given positions, multipliers and parameter."""
        engine = self.engine
        if twin:
            if self._twin is None:
                self._twin = Engine(self.model, complex_scalars=True)
            engine = self._twin
            self._same(engine)
        engine.q[:] = q
        engine.lam[:] = lam[: self.model.nrow]
        engine.v[:] = engine.a[:] = 0.0
        speed: Any = self.speed
        if self.kind == "input":
            engine.input[self.model.inputs.index(self.parameter)] = value
        elif self.kind == TIME:
            engine.time[0] = value
        elif self.kind == GRAVITY:
            engine.gravity[:] = value * self.model.gravity
        elif self.kind == SPEED:
            speed = value
        if self.axis is not None:
            self._rotate(engine, speed)
        return engine

    def _same(self, engine: Engine) -> None:
        """Copy time, inputs and states of events from the engine to another one."""
        for name in ("time", "input", "turn", "locked", "held", "slip", "direction", "states"):
            getattr(engine, name)[:] = getattr(self.engine, name)
        engine.happened[:] = self.engine.happened

    def variant(self, *, beams: bool = True, data: dict[int, Any] | None = None) -> Balance:
        """Return a copy with the same state, without the beams or with other data of elements.

        If the data are complex, `slope` is also the derivative along their imaginary parts.
        """
        out = copy(self)
        if not beams:
            out.model = replace(self.model, beams=())
            out.engine = Engine(out.model)
            self._same(out.engine)
        override = {("beam", i, "data"): x for i, x in (data or {}).items()}
        out._twin = Engine(out.model, complex_scalars=True, override=override)
        return out

    def _rotate(self, engine: Engine, speed: Any) -> None:
        """Set velocities and accelerations of the steady rotation."""
        W = self._rate = speed * self.axis
        for b in self.model.bodies:
            V = np.cross(W, engine.q[b.iq : b.iq + 3] - self.point)
            engine.v[b.iv : b.iv + 3] = V
            engine.v[b.iv + 3 : b.iv + 6] = turned(engine.q[b.iq + 3 : b.iq + 7]).T @ W
            engine.a[b.iv : b.iv + 3] = np.cross(W, V)

    def spin(self, q: Array) -> Array:
        """Return the increments (nv,) of a rotation of all bodies about the axis by 1 rad."""
        out = np.zeros(self.model.nv)
        assert self.axis is not None
        for b in self.model.bodies:
            out[b.iv : b.iv + 3] = np.cross(self.axis, q[b.iq : b.iq + 3] - self.point)
            out[b.iv + 3 : b.iv + 6] = rotation_matrix(q[b.iq + 3 : b.iq + 7]).T @ self.axis
        return out

    def _turns_freely(self) -> bool:
        """Return whether joints and drives allow a rotation of all bodies about the axis."""
        self.engine.v[:] = self.spin(self.engine.q)
        moved = self.engine.constraints()[1]
        self.engine.v[:] = 0.0
        still = self.engine.constraints()[1]
        most = np.abs((moved - still) * self.engine.row_metres).max(initial=0.0)
        return bool(most <= FIXED * self.model.size)

    # -- residual and matrices ------------------------------------------------------------------

    def residual(self, q: Array, lam: Array, value: float) -> Array:
        """Return [r, C, 0] (size,)."""
        engine = self.at(q, lam, value)
        r = engine.residual()
        if self.gauge:
            return np.concatenate([r + lam[-1] * self.spin(q), engine.constraints()[0], [0.0]])
        return np.concatenate([r, engine.constraints()[0]])

    def push(self, q: Array, lam: Array, value: float) -> Array:
        """Return the derivative (size,) of the residual with respect to the parameter."""
        engine = self.at(q, lam, value + 1j * IMAGINARY, twin=True)
        r = engine.residual().imag / IMAGINARY
        c = engine.constraints()[0].imag / IMAGINARY
        return np.concatenate([r, c, np.zeros(int(self.gauge))])

    def matrix(self, q: Array, lam: Array, value: float) -> Any:
        """Return ``[K, Cq^T; Cq, 0]`` (size, size), bordered by the row of the azimuth if any."""
        return self._bordered(self._matrix(self.at(q, lam, value)), q)

    def slope(self, q: Array, lam: Array, value: float, step: Array, rate: float = 1.0) -> Any:
        """Return the derivative of `matrix` along increments of all unknowns and of the parameter.

        It is exact, by a complex step of the engine.
        """
        nv = self.model.nv
        h = 1j * IMAGINARY
        turned = displaced(self.model, q, h * step[:nv])
        engine = self.at(turned, lam + h * step[nv:], value + h * rate, twin=True)
        A = self._matrix(engine)
        A.data = A.data.imag / IMAGINARY
        slope = A.astype(np.float64)
        if not self.gauge:
            return slope.tocsc()
        return sp.block_diag([slope, sp.csc_matrix((1, 1))], format="csc")

    def mass(self, q: Array, lam: Array, value: float) -> Any:
        """Return the mass matrix (nv, nv) in the coordinates of the increments."""
        nv = self.model.nv
        return newton_sparse(self.at(q, lam, value), 1.0, 0.0, 0.0)[:nv, :nv].tocsc()

    def metric(self, q: Array, lam: Array, value: float) -> Array:
        """Return masses (nv,) of all increments, with a lower bound on the rotary inertia.

        The bound is the mass on a lever of the size of the mechanism over the number of bodies, so
        that spin about a slender axis is scaled as other motions are.
        """
        out = self.mass(q, lam, value).diagonal()
        arm = self.model.size / len(self.model.bodies)
        for b in self.model.bodies:
            out[b.iv + 3 : b.iv + 6] += out[b.iv : b.iv + 3].max() * arm**2
        # masses, inertias and modal masses differ in size: a lower bound for each kind
        kinds = _kinds(self.model)
        most = np.zeros(3)
        np.maximum.at(most, kinds, out)
        return np.asarray(np.maximum(out, LIGHT * most[kinds]))

    def _matrix(self, engine: Engine) -> Any:
        """Return ``[K, Cq^T; Cq, 0]`` without the border; K includes the terms of the rotation."""
        nv = self.model.nv
        A = newton_sparse(engine, 0.0, 0.0, 1.0).tocsr()
        K, Ct, rest = A[:nv, :nv], A[:nv, nv:], A[nv:, nv:]
        if self.axis is not None:
            D = newton_sparse(engine, 0.0, 1.0, 0.0)[:nv, :nv]
            M = newton_sparse(engine, 1.0, 0.0, 0.0)[:nv, :nv]
            O = skew_any(self._rate)
            rates: list[Any] = []
            pulls: list[Any] = []
            for b in self.model.bodies:
                w = engine.v[b.iv + 3 : b.iv + 6]
                zero = np.zeros((b.n, b.n))
                rates += [O, skew_any(w), zero]
                pulls += [O @ O, np.zeros((3, 3)), zero]
            K = K + D @ sp.block_diag(rates, format="csr") + M @ sp.block_diag(pulls, format="csr")
        return blocks([[K, Ct], [Ct.T, rest]], format="csc")

    def _bordered(self, A: Any, q: Array) -> Any:
        nv, nrow = self.model.nv, self.model.nrow
        if self.model.redundant and nrow:
            moves = sp.diags(1.0 / velocity_metres(self.model))
            K = max(abs(moves @ A[:nv, :nv] @ moves).max(), 1e-300)  # N/m
            soft = SOFT / (K * self.engine.row_metres**2)
            A = A - sp.diags(np.concatenate([np.zeros(nv), soft]))
        if not self.gauge:
            return A.tocsc()
        g = np.concatenate([self.spin(q), np.zeros(nrow)])[:, None]
        return blocks([[A, g], [g.T, None]], format="csc")

    # -- states -----------------------------------------------------------------------------------

    def moved(self, q: Array, step: Array) -> Array:
        """Return positions q (nq,) after the first nv components of an increment."""
        return np.asarray(displaced(self.model, q, step[: self.model.nv]))

    def length(self, step: Array) -> float:
        """Return the norm of an increment: root mean square of rotation and translation / size."""
        x = step[: self.model.nv]
        return float(np.sqrt(self.weights @ (x * x)))

    def between(self, q0: Array, q: Array) -> Array:
        """Return the increments (nv,) that lead from q0 to q, rotations as rotation vectors."""
        out = np.zeros(self.model.nv)
        for b in self.model.bodies:
            out[b.iv : b.iv + 3] = q[b.iq : b.iq + 3] - q0[b.iq : b.iq + 3]
            a, e = q0[b.iq + 3 : b.iq + 7], q[b.iq + 3 : b.iq + 7]
            s = a @ e
            v = a[0] * e[1:] - e[0] * a[1:] - np.cross(a[1:], e[1:])
            if s < 0.0:
                s, v = -s, -v
            n = float(np.linalg.norm(v))
            out[b.iv + 3 : b.iv + 6] = v * (2.0 * np.arctan2(n, s) / n if n > 0.0 else 2.0)
            out[b.iv + 6 : b.iv + 6 + b.n] = (
                q[b.iq + 7 : b.iq + 7 + b.n] - q0[b.iq + 7 : b.iq + 7 + b.n]
            )
        return out

    def go_back(self, state: State) -> None:
        """Restore the plastic deformation of the forces at a state."""
        if state.states is not None:
            self.engine.states[:] = state.states
            self._let_touch()

    def count_turns(self, q: Array, lam: Array, value: float) -> None:
        """Count the revolutions of angles at the end of a step, such as of motors behind gears."""
        engine = self.at(q, lam, value)
        if len(engine.turn):
            engine.assemble(0)

    def accept(self, q: Array, lam: Array, value: float) -> tuple[State, Array]:
        """Return the state and its sensor values, with updated turns and plastic deformation."""
        self.count_turns(q, lam, value)
        engine = self.at(q, lam, value)
        velocities = np.array(engine.v)
        engine.yield_forces()
        engine.row()
        sensors = np.array(engine.sensors())
        kept = {name: float(engine.input[i]) for i, name in enumerate(self.model.inputs)}
        state = State(
            q=np.array(q),
            v=velocities,
            lam=np.array(lam[: self.model.nrow]),
            time=float(engine.time[0]),
            turn=np.array(engine.turn),
            inputs=kept,
            states=np.array(engine.states),
        )
        self._let_touch()
        return state, sensors


def _beside_a_path(force: ForceModel) -> str:
    """Return why a path does not follow a contact; "" if it does."""
    if force.kind in ("contact set", "contact slot"):
        return "finds its pairs in the steps of a run; make it single contacts without friction"
    if not slides_freely(force):
        return "sticks and slips, so that the equilibrium is not unique; leave out its friction"
    return "" if force.kind in SMOOTH else "touches at corners that change on the way"


def skew_any(w: Any) -> Any:
    """Return the cross product matrix of a real or complex vector."""
    if not np.iscomplexobj(w):
        return skew(w)
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def turned(e: Any) -> Any:
    """Return the rotation matrix of real or complex Euler parameters."""
    if not np.iscomplexobj(e):
        return rotation_matrix(e / np.linalg.norm(e))
    s, v = e[0], skew_any(e[1:])
    return np.eye(3) + 2.0 * s * v + 2.0 * v @ v


def _kinds(model: Model) -> NDArray[np.intp]:
    """Return the kind (nv,) of each increment: 0 translation, 1 rotation, 2 modal coordinate."""
    return np.concatenate([np.repeat([0, 1, 2], [3, 3, b.n]) for b in model.bodies])


def _weights(model: Model) -> Array:
    """Return the weights (nv,) of squared increments in the arc-length norm."""
    out = np.ones(model.nv)
    shapes = model.shapes or [None] * len(model.bodies)
    for b, shape in zip(model.bodies, shapes, strict=True):
        out[b.iv : b.iv + 3] = 1.0 / model.size**2
        if b.n and shape is not None and shape.modes.size:
            modes = (shape.modes**2).sum(axis=1).mean(axis=0)
            out[b.iv + 6 : b.iv + 6 + b.n] = modes / model.size**2
    return out / len(model.bodies)
