"""Engine: a Model in the memory layout of jousto.h, with one state to step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.engine import library
from jousto.engine.callback import callback
from jousto.engine.model import Model
from jousto.errors import InputError, Problem, SimulationError

Scalars = NDArray[Any]  # float64, or complex128 in the build for derivatives
SIGNALS = {
    "constant": 0,
    "harmonic": 1,
    "table": 2,
    "step": 3,
    "pieces": 4,
    "sum": 5,
    "product": 6,
    "input": 7,
    "switched": 8,
}
COORDINATES = {"axes": 1, "along": 2, "distance": 3, "angle": 4}
FORCES = {"load": 1, "along": 2, "bushing": 3, "modal load": 4, "user": 5}
SENSORS = {
    "position": 1,
    "velocity": 2,
    "orientation": 3,
    "angular velocity": 4,
    "modal": 5,
    "reaction": 6,
    "stress": 7,
    "acceleration": 8,
    "angular acceleration": 9,
    "coordinate": 10,
    "rate": 11,
    "multiplier": 12,
    "element": 13,
    "energy": 14,
    "signal": 15,
    "von mises": 16,
}
OK, NOT_FINITE, SINGULAR_BODY, SINGULAR_JOINT, NO_MEMORY = range(5)
CALLBACK_FAILED, NO_CONVERGENCE, FRICTION_FAILED, EVENT, STEP_TOO_SMALL = range(5, 10)
BALANCE = 11  # entries of a row between the multipliers and the sensors

_STEP = 1e-30  # imaginary


@dataclass(frozen=True, eq=False)
class Tangent:
    """Derivatives of ``r = M a + Cq^T lam - Q`` with respect to a, v and increments of q.

    Attributes
    ----------
    M, D, K : arrays (nv, nv)
        ``dr/da``, ``dr/dv``, ``dr/dq``; K holds the second derivatives of the constraints, times
        lam.
    Cq : array (nrow, nv)
        Constraint Jacobian, ``dC'/dv``.
    """

    M: NDArray[np.float64]
    D: NDArray[np.float64]
    K: NDArray[np.float64]
    Cq: NDArray[np.float64]


class SingularJoints(InputError):
    """Constraint rows that repeat one another."""


class Engine:
    """The compiled engine with the constants of one model and one state.

    ``q``, ``v``, ``a``, ``lam`` and ``time`` are views of the engine's own memory; assign with
    ``engine.q[:] = ...``.

    Parameters
    ----------
    model : Model
        The mechanism.
    complex_scalars : bool
        Use the build with complex numbers: an imaginary step of 1e-30 in any constant or
        initial value gives derivatives to machine precision.
    override : dict, optional
        Replaces arrays of the model by name, for example
        ``{("body", 0, "K"): perturbed_stiffness}``; for derivatives.
    strict : bool
        A singular position is an error; otherwise it is passed with multipliers of least norm.
    """

    def __init__(
        self,
        model: Model,
        *,
        complex_scalars: bool = False,
        override: dict[tuple[str, int, str], Any] | None = None,
        strict: bool = False,
    ) -> None:
        self.model = model
        self._strict = strict
        self.dtype = np.dtype(np.complex128 if complex_scalars else np.float64)
        self._library = library.complex_library() if complex_scalars else library.real_library()
        self._ffi = library.ffi()
        self._keep: list[Any] = []
        self._shared: dict[int, tuple[Any, Any]] = {}
        self._override = override or {}
        self._raised: list[BaseException] = []
        self._model = self._native_model()
        data = self._library.jo_data_new(self._model)
        if data == self._ffi.NULL:
            raise MemoryError("no memory for the engine's workspace")
        self._data = self._ffi.gc(data, self._library.jo_data_free)
        self.q = self._view(self._library.jo_data_q(data), model.nq)
        self.v = self._view(self._library.jo_data_v(data), model.nv)
        self.a = self._view(self._library.jo_data_a(data), model.nv)
        self.lam = self._view(self._library.jo_data_lam(data), model.nrow)
        self.time = self._view(self._library.jo_data_time(data), 1)
        self.work = self._view(self._library.jo_data_work(data), 3)
        self.input = self._view(self._library.jo_data_input(data), len(model.inputs))
        turns = sum(c.kind == "angle" for c in model.coordinates)
        self.turn = self._view(self._library.jo_data_turn(data), turns)
        locks = sum(joint.lock >= 0 for joint in model.joints)
        self.locked = self._view(self._library.jo_data_locked(data), locks, np.intc)
        self.slip = self._view(self._library.jo_data_slip(data), len(model.frictions), np.intc)
        self.happened = self._view(self._library.jo_data_happened(data), len(model.events), np.intc)
        self.counts = self._view(self._library.jo_data_counts(data), 5, np.longlong)
        self.row_size = int(self._library.jo_row_size(self._model))
        self._count = self._ffi.new("long long *", 0)
        for signal in model.signals:
            if signal.kind == "input":
                self.input[signal.count] = signal.data[0]
        self.q[:] = model.q0
        self.v[:] = model.v0

    # -- what the engine computes ---------------------------------------------------------

    def accelerations(self) -> tuple[Scalars, Scalars]:
        """Compute and return a (nv,) and lam (nrow,) at time, q, v."""
        self._check(self._library.jo_accelerations(self._model, self._data))
        return self.a, self.lam

    def assemble(self, iterations: int = 100, tolerance: float = 1e-14) -> None:
        """Close the joints by projecting q and v in the mass metric."""
        scale = tolerance * max(1.0, float(np.abs(self.q).max(initial=0.0)))
        self._check(self._library.jo_assemble(self._model, self._data, iterations, scale))

    def step(self, solver: Any) -> None:
        """Advance by one step of a native solver (see `native_solver`)."""
        self._check(self._library.jo_step(self._model, self._data, solver))

    def run(self, solver: Any, steps: int, every: int, rows: Scalars) -> tuple[int, int]:
        """Advance `steps` steps and fill `rows` (k, row_size) every `every` steps.

        Returns
        -------
        status : int
            0, or what the engine could not do (see `problem`).
        written : int
            Rows written.

        Raises
        ------
        ValueError
            If `rows` is not a contiguous array of the engine's scalars with enough rows.
        """
        needed = (self.steps_done % max(every, 1) + steps) // max(every, 1)
        good = rows.ndim == 2 and rows.shape[0] >= needed and rows.shape[1] == self.row_size
        if not (good and every >= 1 and rows.dtype == self.dtype and rows.flags.c_contiguous):
            raise ValueError(
                f"rows must be a contiguous ({needed} or more, {self.row_size}) array of "
                f"{self.dtype}, and every at least 1"
            )
        written = self._ffi.new("int *", 0)
        pointer = self._pointer(rows)
        status = self._library.jo_run(
            self._model, self._data, solver, steps, every, self._count, written, pointer
        )
        return int(status), int(written[0])

    def row(self) -> Scalars:
        """Return the present state as one row of `run`."""
        out = np.zeros(self.row_size, self.dtype)
        self._check(self._library.jo_row(self._model, self._data, self._pointer(out)))
        return out

    @property
    def steps_done(self) -> int:
        """Steps taken by `run` so far."""
        return int(self._count[0])

    @property
    def error_index(self) -> int:
        """Body or joint of the last error."""
        return int(self._library.jo_data_error_index(self._data))

    def energy(self) -> Scalars:
        """Return kinetic, strain, potential energy and that of the springs (4,), J."""
        out = np.zeros(4, self.dtype)
        self._library.jo_energy(self._model, self._data, self._pointer(out))
        return out

    def constraints(self) -> tuple[Scalars, Scalars]:
        """Return C(q) and Cq v, both (nrow,)."""
        c, cdot = np.zeros(self.model.nrow, self.dtype), np.zeros(self.model.nrow, self.dtype)
        self._library.jo_constraints(self._model, self._data, self._pointer(c), self._pointer(cdot))
        return c, cdot

    def residuals(self) -> tuple[float, float]:
        """Return the largest position and velocity residual."""
        c, cdot = self.constraints()
        return float(np.abs(c).max(initial=0.0)), float(np.abs(cdot).max(initial=0.0))

    def mass_matrix(self, body: int) -> Scalars:
        """Return the mass matrix (6+n, 6+n) of a body for [R'' (body frame), w', p'']."""
        body = range(len(self.model.bodies))[body]  # an index out of range is an IndexError
        n = 6 + self.model.bodies[body].n
        M = np.zeros((n, n), self.dtype)
        self._library.jo_mass_matrix(self._model, self._data, body, self._pointer(M))
        return M

    def residual(self) -> Scalars:
        """Return r = M a + Cq^T lam - Q (nv,) at time, q, v, a, lam.

        Per body on [dR (world), dtheta (body frame), dp], in N, N m and modal force.
        """
        out = np.zeros(self.model.nv, self.dtype)
        self._check(self._library.jo_residual(self._model, self._data, self._pointer(out)))
        return out

    def tangent(self) -> Tangent:
        """Return the exact derivatives of `residual` and of the constraints at this state.

        By complex steps (Squire and Trapp, SIAM Rev. 40, 1998), column by column, with orientation
        increments on the right, q = q0 o exp(dtheta).
        """
        twin = Engine(self.model, complex_scalars=True, override=self._override)
        names = ("q", "v", "a", "lam", "time", "input", "turn", "locked", "slip", "happened")
        for name in names:
            getattr(twin, name)[:] = getattr(self, name).real
        nv, nrow = self.model.nv, self.model.nrow
        M, D, K, Cq = (
            np.zeros((nv, nv)),
            np.zeros((nv, nv)),
            np.zeros((nv, nv)),
            np.zeros((nrow, nv)),
        )
        moves = self._increments()
        for j in range(nv):
            for x, out in ((twin.a, M), (twin.v, D)):
                kept = x[j]
                x[j] += 1j * _STEP
                out[:, j] = twin.residual().imag / _STEP
                if x is twin.v:
                    Cq[:, j] = twin.constraints()[1].imag / _STEP
                x[j] = kept
            kept_q = twin.q.copy()
            twin.q += 1j * _STEP * moves[:, j]
            K[:, j] = twin.residual().imag / _STEP
            twin.q[:] = kept_q
        return Tangent(M, D, K, Cq)

    def _increments(self) -> NDArray[np.float64]:
        """Return dq (nq, nv) of unit increments [dR, dtheta (body frame), dp]."""
        moves = np.zeros((self.model.nq, self.model.nv))
        for b in self.model.bodies:
            e0, e1, e2, e3 = self.q[b.iq + 3 : b.iq + 7].real
            turn = [[-e1, -e2, -e3], [e0, -e3, e2], [e3, e0, -e1], [-e2, e1, e0]]
            moves[b.iq : b.iq + 3, b.iv : b.iv + 3] = np.eye(3)
            moves[b.iq + 3 : b.iq + 7, b.iv + 3 : b.iv + 6] = 0.5 * np.array(turn)
            moves[b.iq + 7 : b.iq + 7 + b.n, b.iv + 6 : b.iv + 6 + b.n] = np.eye(b.n)
        return moves

    def sensors(self) -> Scalars:
        """Return all sensor values (nout,) at the state of the last `accelerations`."""
        out = np.zeros(self.model.nout, self.dtype)
        self._library.jo_sensors(self._model, self._data, self._pointer(out))
        return out

    def native_solver(
        self,
        method: int,
        step: float,
        projection: bool,
        alpha: float = 0.0,
        beta: float = 0.0,
        **options: Any,
    ) -> Any:
        """Return a jo_solver; the options are its further fields."""
        solver = self._ffi.new("jo_solver *")
        solver.method, solver.projection, solver.step = method, int(projection), step
        solver.alpha, solver.beta = alpha, beta
        for name, value in options.items():
            setattr(solver, name, value)
        return solver

    # -- errors -----------------------------------------------------------------------------

    def _check(self, status: int) -> None:
        if status == SINGULAR_BODY:
            raise InputError(self.problem(status))
        if status == SINGULAR_JOINT:
            raise SingularJoints(self.problem(status))
        if status == NOT_FINITE:
            name = self.model.bodies[self.error_index].name
            raise SimulationError(
                f"body '{name}' is no longer finite", time=float(self.time[0].real), body=name
            )
        if status == CALLBACK_FAILED:
            raise SimulationError(
                self.callback_problem(), time=float(self.time[0].real)
            ) from self.cause
        if status != OK:
            raise SimulationError(f"engine status {status}", time=float(self.time[0].real))

    @property
    def cause(self) -> BaseException | None:
        """What a user's Python function raised last, or None."""
        return self._raised[-1] if self._raised else None

    def callback_problem(self) -> str:
        """Return the sentence for a user function that failed."""
        name = self.model.forces[self.error_index].name
        if self.cause is not None:
            return f"force '{name}': its function raised {type(self.cause).__name__}: {self.cause}"
        return (
            f"force '{name}': its function reported an error or returned a value that is not "
            "finite; check it at the positions and velocities of this time"
        )

    def problem(self, status: int) -> Problem:
        """Return the sentence for a singular body or joint."""
        index = self.error_index
        if status == SINGULAR_BODY:
            return Problem(
                f"body '{self.model.bodies[index].name}'",
                "its mass matrix is singular: there is no inertia about some axis (all mass on "
                "one line or at one point); give the part rotary inertia (rotary_inertia=True) "
                "or a point mass with inertia",
            )
        return Problem(
            f"joint '{self.model.joints[index].name}'",
            "its constraints cannot be told from those of other joints: a body is lighter than "
            "its neighbours by a factor of 1e12 or more; join it with one of them",
        )

    # -- memory layout ----------------------------------------------------------------------

    def _pointer(self, array: Scalars) -> Any:
        return self._ffi.cast("jo_real *", array.ctypes.data)

    def _view(self, pointer: Any, count: int, kind: Any = None) -> Scalars:
        dtype = self.dtype if kind is None else np.dtype(kind)
        if count == 0:
            return np.zeros(0, dtype)
        address = int(self._ffi.cast("uintptr_t", pointer))
        return np.asarray(_Memory(self._data, address, count, dtype))

    def _constant(
        self, array: Any, key: tuple[str, int, str] | None = None, shared: Any = None
    ) -> Any:
        """Copy an array to the engine's scalar type and keep it alive; None stays NULL.

        Arrays made of the same object `shared` are copied once: bodies of one reduced part use
        the same memory, and the processor's cache holds them all.
        """
        if key is not None and key in self._override:
            array = self._override[key]
        if array is None:
            return self._ffi.NULL
        if shared is not None and id(shared) in self._shared:
            return self._shared[id(shared)][1]
        flat = np.asarray(array, dtype=self.dtype).ravel()
        room = np.zeros(flat.nbytes + 128, np.uint8)  # aligned to cache lines
        start = -room.ctypes.data % 64
        copy = room[start : start + max(flat.nbytes, self.dtype.itemsize)].view(self.dtype)
        copy[: flat.size] = flat
        self._keep.append(copy)
        if shared is not None:
            self._shared[id(shared)] = (shared, self._pointer(copy))
        return self._pointer(copy)

    def _structs(self, kind: str, count: int) -> Any:
        array = self._ffi.new(f"{kind}[]", max(count, 1))
        self._keep.append(array)
        return array

    def _native_model(self) -> Any:
        m = self.model
        model = self._ffi.new("jo_model *")
        pairs = self._pairs()
        updates = [u for column in m.elimination.updates for u in column]
        belows = [b for column in m.elimination.below for b in column]
        sizes = {
            "nbody": len(m.bodies),
            "nmarker": len(m.markers),
            "nactive": m.active,
            "ncoordinate": len(m.coordinates),
            "njoint": len(m.joints),
            "nline": sum(len(joint.lines) for joint in m.joints),
            "npair": len(pairs),
            "ncolumn": len(m.joints),
            "nblock": m.elimination.count,
            "nsignal": len(m.signals),
            "nforce": len(m.forces),
            "nfriction": len(m.frictions),
            "nevent": len(m.events),
            "nsensor": len(m.sensors),
            "nturn": sum(c.kind == "angle" for c in m.coordinates),
            "nlock": sum(joint.lock >= 0 for joint in m.joints),
            "ninput": len(m.inputs),
            "redundant": -1 if self._strict else int(m.redundant),
            "nq": m.nq,
            "nv": m.nv,
            "nrow": m.nrow,
            "nout": m.nout,
        }
        for name, size in sizes.items():
            setattr(model, name, size)
        model.size = m.size
        model.gravity = self._constant(m.gravity, ("model", 0, "gravity"))
        model.body = self._bodies()
        model.marker = self._markers()
        model.coordinate = self._coordinates()
        model.joint = self._joints()
        model.line = self._lines()
        model.pair = self._fill("jo_pair", pairs)
        starts = np.cumsum([0, *(len(c) for c in m.elimination.below)])
        columns = [
            (joint, int(starts[c]), len(m.elimination.below[c]))
            for c, joint in enumerate(m.elimination.order)
        ]
        model.column = self._fill("jo_column", columns)
        model.below = self._fill("jo_below", belows)
        model.update = self._fill("jo_update", updates)
        first = np.cumsum([0, *(len(c) for c in m.elimination.updates)])
        model.update_first = self._fill("int", [int(i) for i in first])
        model.signal = self._signals()
        model.force = self._forces()
        model.friction = self._frictions()
        model.event = self._fill(
            "jo_event", [(e.output, e.direction, int(e.stop), e.threshold) for e in m.events]
        )
        model.sensor = self._sensors()
        return model

    def _fill(self, kind: str, values: list[Any]) -> Any:
        array = self._structs(kind, len(values))
        for i, value in enumerate(values):
            array[i] = value
        return array

    def _pairs(self) -> list[tuple[int, int, int, int, int]]:
        """Pairs of joint sides on one body and the block of S that they contribute to."""
        m = self.model
        place = {joint: c for c, joint in enumerate(m.elimination.order)}
        sides: dict[int, list[tuple[int, int]]] = {}
        for k, joint in enumerate(m.joints):
            for side, marker in enumerate(joint.sides):
                if m.markers[marker].body >= 0:
                    sides.setdefault(m.markers[marker].body, []).append((k, side))
        pairs = []
        for body in sorted(sides):
            for k, side_k in sides[body]:
                for j, side_j in sides[body]:
                    if place[k] >= place[j]:
                        pairs.append((k, side_k, j, side_j, m.elimination.blocks[k, j]))
        return pairs

    def _bodies(self) -> Any:
        pad, rows_d, rows_b, dense = (
            getattr(self._library, name) for name in ("JO_PAD", "JO_ROW_D", "JO_ROW_B", "JO_DENSE")
        )
        structs = self._structs("jo_body", len(self.model.bodies))
        for i, body in enumerate(self.model.bodies):
            b = structs[i]
            b.n, b.iq, b.iv = body.n, body.iq, body.iv
            b.np = np_ = -(-body.n // pad) * pad
            for name in ("mass", "S0", "J0"):
                setattr(b, name, self._constant(getattr(body, name), ("body", i, name)))
            for name in ("I3", "B0", "D0", "K", "D"):
                array = self._override.get(("body", i, name), getattr(body, name))
                setattr(b, name, self._constant(_padded(np.asarray(array), np_), shared=array))
            for name, rows in (("ED", rows_d), ("EB", rows_b)):
                array = self._override.get(("body", i, name), getattr(body, name))
                setattr(
                    b,
                    name,
                    self._constant(_blocked(np.asarray(array), np_, rows, dense), shared=array),
                )
        return structs

    def _markers(self) -> Any:
        structs = self._structs("jo_marker", len(self.model.markers))
        for i, marker in enumerate(self.model.markers):
            s = structs[i]
            s.body = marker.body
            s.turns = int(marker.turns)
            np_ = 0
            if marker.body >= 0:
                n, pad = self.model.bodies[marker.body].n, self._library.JO_PAD
                np_ = -(-n // pad) * pad
            for name in ("u0", "A0"):
                setattr(s, name, self._constant(getattr(marker, name), ("marker", i, name)))
            for name in ("Phi", "Psi"):
                shapes = self._override.get(("marker", i, name), getattr(marker, name))
                padded = _padded(np.asarray(shapes), np_) if shapes is not None and np_ else None
                setattr(s, name, self._constant(padded))
            if marker.chi is not None and np_:
                chi = self._override.get(("marker", i, "chi"), marker.chi)
                s.chi = self._constant(_padded(np.asarray(chi), np_))
        return structs

    def _coordinates(self) -> Any:
        structs = self._structs("jo_coordinate", len(self.model.coordinates))
        turn = 0
        for s, coordinate in zip(structs, self.model.coordinates, strict=False):
            s.type, s.a, s.b = COORDINATES[coordinate.kind], coordinate.a, coordinate.b
            s.axis_a, s.axis_b, s.turn = coordinate.axis_a, coordinate.axis_b, -1
            if coordinate.kind == "angle":
                s.turn, turn = turn, turn + 1
        return structs

    def _lines(self) -> Any:
        lines = [(joint, line) for joint in self.model.joints for line in joint.lines]
        structs = self._structs("jo_line", len(lines))
        for i, (joint, line) in enumerate(lines):
            s = structs[i]
            s.count, s.signal = len(line.coordinates), line.signal
            for k, index in enumerate(line.coordinates):
                coordinate = self.model.coordinates[index]
                s.coordinate[k] = index
                pairs = list(zip(joint.sides[::2], joint.sides[1::2], strict=True))
                s.side[k] = 2 * pairs.index((coordinate.a, coordinate.b))
            data = np.zeros(3)
            data[0] = line.offset
            data[1 : 1 + len(line.factors)] = line.factors
            s.data = self._constant(data, ("line", i, "data"))
        return structs

    def _joints(self) -> Any:
        structs = self._structs("jo_joint", len(self.model.joints))
        line = 0
        for i, joint in enumerate(self.model.joints):
            s = structs[i]
            s.nside, s.coincident = len(joint.sides), int(joint.coincident)
            for k, marker in enumerate(joint.sides):
                s.side[k] = marker
            s.nperp, s.nrow, s.row = len(joint.perpendicular), joint.rows, joint.row
            s.nline, s.line, s.lock = len(joint.lines), line, joint.lock
            line += len(joint.lines)
            for r, (a, b) in enumerate(joint.perpendicular):
                s.perp_a[r], s.perp_b[r] = a, b
        return structs

    def _signals(self) -> Any:
        structs = self._structs("jo_signal", len(self.model.signals))
        for i, signal in enumerate(self.model.signals):
            s = structs[i]
            s.type, s.count, s.degree = SIGNALS[signal.kind], signal.count, signal.degree
            s.child[0], s.child[1] = signal.children
            s.data = self._constant(signal.data, ("signal", i, "data"))
        return structs

    def _forces(self) -> Any:
        structs = self._structs("jo_force", len(self.model.forces))
        for i, force in enumerate(self.model.forces):
            s = structs[i]
            s.type, s.a, s.b = FORCES[force.kind], force.a, force.b
            s.coordinate, s.body = force.coordinate, force.body
            s.follow, s.active, s.signal = int(force.follow), int(force.active), force.signal
            s.reference, s.spring, s.damper = force.reference, force.spring, force.damper
            data = force.data
            if force.kind == "modal load":  # padded like the modes
                n, pad = self.model.bodies[force.body].n, self._library.JO_PAD
                data = _padded(data, 6 - (-n // pad) * pad)
            s.data = self._constant(data, ("force", i, "data"))
            if force.function is not None:
                s.function, s.user, kept = callback(self._ffi, force.function, self._raised)
                self._keep.append(kept)
        return structs

    def _frictions(self) -> Any:
        structs = self._structs("jo_friction", len(self.model.frictions))
        for i, friction in enumerate(self.model.frictions):
            s = structs[i]
            s.joint, s.coordinate = friction.joint, friction.coordinate
            s.law, s.lock = int(friction.sticks), friction.lock
            s.data = self._constant(friction.data, ("friction", i, "data"))
        return structs

    def _sensors(self) -> Any:
        structs = self._structs("jo_sensor", len(self.model.sensors))
        for i, sensor in enumerate(self.model.sensors):
            s = structs[i]
            s.type, s.object = SENSORS[sensor.kind], sensor.object
            s.other, s.frame = sensor.other, sensor.frame
            s.offset, s.count = sensor.offset, sensor.count
            if sensor.rows is not None:
                n, pad = self.model.bodies[sensor.object].n, self._library.JO_PAD
                s.rows = self._constant(_padded(sensor.rows, -(-n // pad) * pad))
        return structs


class _Memory:
    """Engine memory for NumPy; keeps the workspace alive as long as a view of it."""

    def __init__(self, owner: Any, address: int, count: int, dtype: np.dtype[Any]) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "shape": (count,),
            "typestr": dtype.str,
            "data": (address, False),
        }


def displaced(model: Model, q: Scalars, increment: Scalars) -> Scalars:
    """Return q (nq,) moved by increments (nv,): dR (world), dtheta (body frame), dp."""
    out = np.array(q, dtype=np.result_type(q, increment))
    for body in model.bodies:
        dx = increment[body.iv : body.iv + 6 + body.n]
        out[body.iq : body.iq + 3] += dx[:3]
        e0, e = out[body.iq + 3], out[body.iq + 4 : body.iq + 7].copy()
        half = 0.5 * dx[3:6]
        angle = np.sqrt(half @ half)
        d0, d = np.cos(angle), half * (np.sin(angle) / angle if angle != 0.0 else 1.0)
        out[body.iq + 3] = e0 * d0 - e @ d
        out[body.iq + 4 : body.iq + 7] = e0 * d + d0 * e + np.cross(e, d)
        out[body.iq + 7 : body.iq + 7 + body.n] += dx[6:]
    return out


def _blocked(E: NDArray[Any], padded_n: int, rows: int, dense: int) -> NDArray[Any]:
    """Order (c, j, k) as jousto.h says: blocks of rows, or for large n triangles of tiles."""
    n = E.shape[2]
    if n == 0:
        return E
    if padded_n <= dense:
        padded = np.zeros((E.shape[0], padded_n, n), E.dtype)
        padded[:, :n] = E
        return np.ascontiguousarray(padded.reshape(-1, rows, n).swapaxes(1, 2))
    padded = np.zeros((E.shape[0], padded_n, padded_n), E.dtype)
    padded[:, :n, :n] = E
    count = padded_n // 4
    tiles = padded.reshape(-1, count, 4, count, 4).transpose(0, 3, 1, 4, 2)  # c, kb, jb, k, j
    kb, jb = np.triu_indices(count)
    return np.ascontiguousarray(tiles[:, kb, jb])


def _padded(array: NDArray[Any], length: int) -> NDArray[Any]:
    """Pad the last axis with zeros."""
    out = np.zeros((*array.shape[:-1], length), array.dtype)
    out[..., : array.shape[-1]] = array
    return out
