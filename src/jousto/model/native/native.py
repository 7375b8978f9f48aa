"""Engine: a Model in the memory layout of jousto.h, with one state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, SimulationError
from jousto.base.object_repr import described
from jousto.base.rotation_rates import rates_of_parameters
from jousto.model.model import Model
from jousto.model.native import library
from jousto.model.native.damage_meter import meter_size
from jousto.model.native.failures import AT_BODY, failure
from jousto.model.native.header import kind, kinds, named, places
from jousto.model.native.layout import Layout
from jousto.model.newton_pattern import newton_entries, newton_pattern

Scalars = NDArray[Any]  # float64, or complex128 in the build for derivatives

# state copied when an engine is cloned
STATE = (
    *("q", "v", "a", "lam", "time", "input", "turn", "happened"),
    *("locked", "held", "slip", "direction", "states"),
)
# fields of jo_pace
PACE = ("step", "farthest", "ahead", "latest", "worst", "missed", "done")
# joints count as closed below this gap, relative to the size of the mechanism or to its distance
# from the origin
CLOSED = 1e-14
CONTACT_ENERGIES = ("stored", "restitution", "friction")
"""Energies of contacts: stored, and lost by normal forces and by friction."""
NO_EVENTS = np.zeros((0, 3))
IMAGINARY = 1e-30  # imaginary step, for derivatives exact to round-off


@dataclass(frozen=True, eq=False)
class Tangent:
    """Derivatives of ``r = M a + Cq^T lam - Q`` with respect to a, v and increments of q.

    Attributes
    ----------
    M, D, K : arrays (nv, nv)
        ``dr/da``, ``dr/dv``, ``dr/dq``; K contains the second derivatives of the constraints, times
        lam.
    Cq : array (nrow, nv)
        Constraint Jacobian, ``dC'/dv``.
    """

    M: NDArray[np.float64]
    D: NDArray[np.float64]
    K: NDArray[np.float64]
    Cq: NDArray[np.float64]


class SingularJoints(InputError):
    """Error raised for redundant or contradictory constraint rows."""


class _View:
    """Array in the memory of an engine: the library's function ``jo_data_NAME`` has its address.

    Parameters
    ----------
    count : function
        Number of its elements for a model.
    kind : type, optional
        Type of the elements; None for the scalars of the engine.
    """

    def __init__(self, count: Callable[[Model], int], kind: Any = None) -> None:
        self._count, self._kind = count, kind

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, engine: Any, owner: type) -> Any:
        if engine is None:
            return self
        pointer = getattr(engine._library, f"jo_data_{self._name}")(engine._data)
        made = engine._view(pointer, self._count(engine.model), self._kind)
        vars(engine)[self._name] = made  # the next use finds it without this function
        return made


@explained
@described
class Engine:
    """The compiled engine with the constants of one model, and one state.

    ``q``, ``v``, ``a``, ``lam`` and ``time`` are views of the engine's own memory; assign with
    ``engine.q[:] = ...``.

    Parameters
    ----------
    model : Model
        The mechanism.
    complex_scalars : bool
        Whether to use the build with complex numbers: an imaginary step of 1e-30 in any constant or
        initial value gives derivatives to machine precision.
    override : dict, optional
        Arrays that replace those of the model, by name, for example
        ``{("body", 0, "K"): perturbed_stiffness}``; for derivatives.
    strict : bool
        Whether a singular position is an error; otherwise the multipliers are those of least norm.
    implicit : bool
        Whether Newton's matrix is laid out, which implicit methods need.
    """

    def __init__(
        self,
        model: Model,
        *,
        complex_scalars: bool = False,
        override: dict[tuple[str, int, str], Any] | None = None,
        strict: bool = False,
        implicit: bool = True,
    ) -> None:
        self.model = model
        self._implicit = implicit
        self.dtype = np.dtype(np.complex128 if complex_scalars else np.float64)
        self._library = library.complex_library() if complex_scalars else library.real_library()
        self._ffi = library.ffi()
        self._override = override or {}
        self._layout = Layout(
            self._library, self._ffi, model, self.dtype, self._override, strict, implicit
        )
        self._model = self._layout.model
        data = self._library.jo_data_new(self._model)
        if data == self._ffi.NULL:
            raise MemoryError("no memory for the engine's workspace")
        self._data = self._ffi.gc(data, self._library.jo_data_free)
        self.counts = self._library.jo_data_counts(data)
        self.row_size = int(self._library.jo_row_size(self._model))
        self._count = self._ffi.new("long long *", 0)
        self._entries: tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]] | None = None
        for signal in model.signals if model.inputs else ():
            if signal.kind == "input":
                self.input[signal.count] = named("jo_constant_data", signal.data).value
        self.q[:] = model.q0
        self.v[:] = model.v0
        if model.nstate:
            self.start_states()

    # -- its memory: views, made at their first use --------------------------------------------

    q = _View(lambda model: model.nq)
    v = _View(lambda model: model.nv)
    a = _View(lambda model: model.nv)
    lam = _View(lambda model: model.nrow)
    time = _View(lambda model: 1)
    work = _View(lambda model: len(places("jo_work")))
    power = _View(lambda model: len(places("jo_work")))
    input = _View(lambda model: len(model.inputs))
    turn = _View(lambda model: sum(c.kind == "angle" for c in model.coordinates))
    locked = _View(lambda model: sum(joint.lock >= 0 for joint in model.joints), np.intc)
    held = _View(lambda model: 2 * sum(joint.lock >= 0 for joint in model.joints))
    direction = _View(lambda model: 2 * len(model.frictions))
    rub = _View(lambda model: 2 * len(model.frictions))
    slip = _View(lambda model: len(model.frictions), np.intc)
    happened = _View(lambda model: len(model.events), np.intc)
    joint = _View(lambda model: model.nx + model.nu)
    contact_energy = _View(lambda model: len(CONTACT_ENERGIES) if model.touches else 0)

    @cached_property
    def gravity(self) -> Scalars:
        """Acceleration of free fall (3,), m/s2, for this engine only."""
        return self._view(self._model.gravity, 3)

    @cached_property
    def meters(self) -> Scalars:
        """Memory of the damage meters."""
        count = sum(meter_size(meter.rule) for meter in self.model.meters)
        return self._view(self._library.jo_data_memory(self._data), count, np.float64)

    @cached_property
    def bent(self) -> Scalars:
        """Largest bending of each beam element so far (nbeam, 2)."""
        count = 2 * len(self.model.beams)
        found = self._view(self._library.jo_data_bent(self._data), count, np.float64)
        return found.reshape(-1, 2)

    @cached_property
    def states(self) -> Scalars:
        """First-order states of forces."""
        pointer = self._library.jo_data_states(self._model, self._data)
        return self._view(pointer, self.model.nstate)

    @cached_property
    def state_rates(self) -> Scalars:
        """Rates of the first-order states."""
        pointer = self._library.jo_data_state_rates(self._model, self._data)
        return self._view(pointer, self.model.nstate)

    # -- evaluations -----------------------------------------------------------------------

    def start_states(self) -> None:
        """Set the states of forces to their values at the start of a run, at time, q, v."""
        self._library.jo_start_states(self._model, self._data)

    def yield_forces(self) -> None:
        """Update the states of yielding forces after a slow motion to q."""
        self._library.jo_yield(self._model, self._data)

    def contacts(self) -> NDArray[np.float64]:
        """Return the points (k, 25) at which bodies touch, or nearly do, at this state.

        Columns as in ``jo_touch`` of jousto.h, which `named` splits.
        """
        out = np.zeros((sum(force.points for force in self.model.forces), self._width("jo_touch")))
        place = self._ffi.cast("jo_touch *", out.ctypes.data)
        count = self._library.jo_contact_report(self._model, self._data, len(out), place)
        return out[:count]

    def touched(self) -> tuple[NDArray[np.float64], int]:
        """Return the contacts (k, 14) that have parted in the last call, and the dropped ones.

        Columns as in ``jo_touched`` of jousto.h; dropped is the number of contacts since the start
        for which the engine had no room.
        """
        lib, count, dropped = self._library, self._ffi.new("int *"), self._ffi.new("long long *")
        rows, width = lib.jo_data_touched(self._data, count, dropped), self._width("jo_touched")
        out = np.zeros((count[0], width))
        if count[0]:
            self._ffi.memmove(self._ffi.from_buffer(out), rows, 8 * width * count[0])
        return out, int(dropped[0])

    def touching(self) -> NDArray[np.float64]:
        """Return the contacts (k, 14) that touch now, as `touched`; they part at NaN."""
        out = np.zeros((len(self.model.forces), self._width("jo_touched")))
        place = self._ffi.cast("jo_touched *", out.ctypes.data)
        return out[: self._library.jo_data_touching(self._model, self._data, place)]

    @staticmethod
    def _width(struct: str) -> int:
        """Return the number of numbers of a struct."""
        return int(max(place.stop for place in places(struct).values()))

    def unproven(self) -> tuple[int, NDArray[np.float64]]:
        """Return the number of steps so far in which a gap may have closed for a moment.

        The first of them are rows (k, 4): time, s; force, -1 for a pair that was not searched;
        shape that is touched and tip of a pair in a slot, else -1.
        """
        lib = self._library
        out = np.zeros((lib.JO_MOST_DOUBTS, lib.JO_DOUBT))
        count = lib.jo_data_unproven(self._data, self._ffi.cast("double *", out.ctypes.data))
        return int(count), out[:count]

    def openings(self) -> NDArray[np.float64]:
        """Return rows (k, 2) of the openings of valves since the last call: change, time.

        The change is the largest one between stages of ROS2 or ends of steps of an implicit method,
        1: from closed to open; the time is that of the later one, s.
        """
        out = np.zeros((sum(len(force.openings) for force in self.model.forces), 2))
        if len(out):
            self._library.jo_data_openings(self._data, self._ffi.cast("double *", out.ctypes.data))
        return out

    def brief_touches(self) -> tuple[int, NDArray[np.float64]]:
        """Return the number of reported touches so far that last for less than 10 steps.

        The first of them are rows (k, 3): time, s; first state of the contact; duration, s.
        """
        lib = self._library
        out = np.zeros((lib.JO_MOST_BRIEF, lib.JO_BRIEF))
        count = lib.jo_data_brief(self._data, self._ffi.cast("double *", out.ctypes.data))
        return int(count), out[:count]

    @property
    def proof(self) -> Any:
        """Number of parts of steps that were proven to miss no contact.

        ``at_once``; ``advanced``, after halvings of their length; ``events``, up to an event;
        ``most``: largest number of halvings.
        """
        return self._library.jo_data_proof(self._data)

    def accelerations(self) -> tuple[Scalars, Scalars]:
        """Compute and return a (nv,) and lam (nrow,) at time, q, v."""
        self._check(self._library.jo_accelerations(self._model, self._data))
        return self.a, self.lam

    def tree_accelerations(self) -> tuple[Scalars, Scalars]:
        """Compute and return a and lam through joint coordinates, for a model with a tree."""
        self._check(self._library.jo_tree_accelerations(self._model, self._data))
        return self.a, self.lam

    def assemble(self, iterations: int = 100) -> None:
        """Close the joints by projecting q and v in the mass metric."""
        places = self.q[self._origins]
        farthest = max(self.model.size, float(np.abs(places).max(initial=0.0)))
        closed = CLOSED * farthest
        self._check(self._library.jo_assemble(self._model, self._data, iterations, closed))

    def step(self, solver: Any) -> None:
        """Advance by one step of a native solver (see `native_solver`)."""
        self._check(self._library.jo_step(self._model, self._data, solver))

    def run(self, solver: Any, steps: int, every: int, rows: Scalars) -> tuple[str, int]:
        """Advance `steps` steps and fill `rows` (k, row_size), one row per `every` steps.

        Returns
        -------
        status : str
            "ok", "event" if an event ended the run, or a failure (see `problem`).
        written : int
            Number of rows written.

        Raises
        ------
        ValueError
            If `rows` is not a contiguous array of the engine's scalars with enough rows.
        """
        self._fits(steps, every, rows)
        written = self._ffi.new("int *", 0)
        pointer = self._pointer(rows)
        status = self._library.jo_run(
            self._model, self._data, solver, steps, every, self._count, written, pointer
        )
        return kind("jo_status", status), int(written[0])

    def paced(
        self, solver: Any, steps: int, every: int, rows: Scalars, pace: Mapping[str, Any]
    ) -> tuple[str, int, dict[str, float]]:
        """Run in real time: each step begins when it is due; other threads run meanwhile.

        Parameters
        ----------
        pace : mapping
            Fields of ``jo_pace`` by name, and ``edges`` and ``late``, contiguous arrays (k,) and
            (k + 1,): `late` is the histogram of the delays of the steps.

        Returns
        -------
        status : str
            See `run`.
        written : int
            Number of rows written.
        pace : dict
            The fields of ``jo_pace``; "done" is the number of finished steps. The call returns
            early at an event, or if the steps are too far behind.
        """
        self._fits(steps, every, rows)
        written = self._ffi.new("int *", 0)
        given = self._ffi.new("jo_pace *", {k: v for k, v in pace.items() if k in PACE})
        edges = self._ffi.from_buffer("double *", pace["edges"])
        late = self._ffi.from_buffer("long long *", pace["late"])
        status = self._library.jo_paced(
            *(self._model, self._data, solver, given, steps, len(pace["edges"]), edges, late),
            *(every, self._count, written, self._pointer(rows)),
        )
        found = {name: getattr(given, name) for name in PACE}
        return kind("jo_status", status), int(written[0]), found

    def _fits(self, steps: int, every: int, rows: Scalars) -> None:
        needed = (self.steps_done % max(every, 1) + steps) // max(every, 1)
        needed += any(event.stop for event in self.model.events)
        good = rows.ndim == 2 and rows.shape[0] >= needed and rows.shape[1] == self.row_size
        if not (good and every >= 1 and rows.dtype == self.dtype and rows.flags.c_contiguous):
            raise ValueError(
                f"rows must be a contiguous ({needed} or more, {self.row_size}) array of "
                f"{self.dtype}, and every at least 1"
            )

    def happenings(self) -> NDArray[np.float64]:
        """Return time, event and direction (k, 3) of the events in the last `run` or `step`."""
        count = int(self._library.jo_data_logged(self._data))
        if count == 0:
            return NO_EVENTS
        log = self._ffi.buffer(self._library.jo_data_log(self._data), 24 * count)
        return np.frombuffer(log, np.float64).reshape(count, 3).copy()

    def mark(self) -> Callable[[], None]:
        """Return a function that restores the current state of the engine."""
        size, done = int(self._library.jo_data_bytes(self._model)), self.steps_done
        memory = bytes(self._ffi.buffer(self._data, size))

        def rewind() -> None:
            self._ffi.memmove(self._data, memory, size)
            self.steps_done = done

        return rewind

    def restart(self) -> None:
        """Reset the history of methods and events, after the state was replaced."""
        self._library.jo_restart(self._data)

    def follow(self, solver: Any, last: int, tries: int, rows: Scalars) -> tuple[str, int]:
        """Advance with error control to the end of `rows`, to row `last`, or for `tries` steps.

        Rows are at times ``start + k step``; the first call begins at the present state, row 0,
        later calls continue from the previous one.

        Returns
        -------
        status : str
            "ok", or a failure (see `problem`).
        written : int
            Number of rows written.
        """
        written = self._ffi.new("int *", 0)
        status = self._library.jo_follow(
            self._model,
            self._data,
            solver,
            last,
            tries,
            len(rows),
            self._count,
            written,
            self._pointer(rows),
        )
        return kind("jo_status", status), int(written[0])

    def row(self) -> Scalars:
        """Return the current state as one row of `run`."""
        out = np.zeros(self.row_size, self.dtype)
        self._check(self._library.jo_row(self._model, self._data, self._pointer(out)))
        return out

    @property
    def steps_done(self) -> int:
        """Number of steps done by `run` so far."""
        return int(self._count[0])

    @steps_done.setter
    def steps_done(self, count: int) -> None:
        self._count[0] = count

    @property
    def error_index(self) -> int:
        """Index of the body, joint, force, friction or event of the last error."""
        return int(self._library.jo_data_error_index(self._data))

    def energy(self) -> Scalars:
        """Return kinetic, strain, potential and spring energy (4,), J."""
        out = np.zeros(len(places("jo_energies")), self.dtype)
        self._library.jo_energy(
            self._model, self._data, self._ffi.cast("jo_energies *", out.ctypes.data)
        )
        return out

    def constraints(self) -> tuple[Scalars, Scalars]:
        """Return C(q) and Cq v, both (nrow,)."""
        c, cdot = np.zeros(self.model.nrow, self.dtype), np.zeros(self.model.nrow, self.dtype)
        self._library.jo_constraints(self._model, self._data, self._pointer(c), self._pointer(cdot))
        return c, cdot

    @cached_property
    def row_metres(self) -> NDArray[np.float64]:
        """Return the length in m that one unit of each constraint row represents, (nrow,).

        It is 1 for a row that is a length, and the size of the mechanism for an angle or a cosine.
        """
        out = np.zeros(self.model.nrow, self.dtype)
        self._library.jo_row_metres(self._model, self._pointer(out))
        return np.asarray(out.real)

    @cached_property
    def _origins(self) -> NDArray[np.intp]:
        """Indices of the origins R of the bodies in q."""
        first = np.array([body.iq for body in self.model.bodies], dtype=np.intp)
        return np.asarray((first[:, None] + np.arange(3)).ravel())

    def residuals(self) -> tuple[float, float]:
        """Return the largest position residual, m, and velocity residual, m/s."""
        gaps = [np.abs(x * self.row_metres).max(initial=0.0) for x in self.constraints()]
        return float(gaps[0]), float(gaps[1])

    def mass_matrix(self, body: int) -> Scalars:
        """Return the mass matrix (6+n, 6+n) of a body for [R'' (body frame), w', p'']."""
        body = range(len(self.model.bodies))[body]  # raises IndexError for an index out of range
        n = 6 + self.model.bodies[body].n
        M = np.zeros((n, n), self.dtype)
        self._library.jo_mass_matrix(self._model, self._data, body, self._pointer(M))
        return M

    def residual(self) -> Scalars:
        """Return r = M a + Cq^T lam - Q (nv,) at time, q, v, a, lam.

        Components per body for [dR (world), dtheta (body frame), dp], in N, N m and modal force.
        """
        out = np.zeros(self.model.nv, self.dtype)
        self._check(self._library.jo_residual(self._model, self._data, self._pointer(out)))
        return out

    def body_loads(self, body: int) -> Scalars:
        """Return the loads (nforce + nfriction + njoint, 6 + n) of each force, friction and joint.

        A row is ``[force, moment about the origin of the body frame, modal forces]`` on one body at
        time, q, v, lam, resolved in its frame; 0 after a release by an event.
        """
        model = self.model
        body = range(len(model.bodies))[body]  # raises IndexError for an index out of range
        count = len(model.forces) + len(model.frictions) + len(model.joints)
        out = np.zeros((count, 6 + model.bodies[body].n), self.dtype)
        self._check(self._library.jo_body_loads(self._model, self._data, body, self._pointer(out)))
        return out

    def newton_matrix(self, ca: float, cv: float, cq: float) -> Scalars:
        """Return ``[ca M + cv D + cq K, Cq^T; cv Cq + cq d(Cq v)/dq, 0]`` at this state.

        M, D, K are those of `tangent`, but from formulas; the last rows are those of the constraint
        velocities: the matrix of the implicit methods, (nv + nrow, nv + nrow).
        """
        self._needs_newton()
        refuse_dense(self.model)
        size = self.model.nv + self.model.nrow
        out = np.zeros((size, size), self.dtype)
        self._check(
            self._library.jo_newton_matrix(self._model, self._data, ca, cv, cq, self._pointer(out))
        )
        return out

    def newton_sparse(self, ca: float, cv: float, cq: float) -> Any:
        """Return `newton_matrix` as a sparse matrix (scipy CSR), without a dense copy."""
        self._needs_newton()
        refuse_dense(self.model)
        values = np.zeros(newton_pattern(self.model).reals, self.dtype)
        self._check(
            self._library.jo_newton_values(
                self._model, self._data, ca, cv, cq, self._pointer(values)
            )
        )
        if self._entries is None:
            self._entries = newton_entries(self.model)
        at, rows, columns = self._entries
        size = self.model.nv + self.model.nrow
        return scipy.sparse.csr_matrix((values[at], (rows, columns)), shape=(size, size))

    def _needs_newton(self) -> None:
        if not self._implicit:
            raise ValueError("this engine has no Newton matrix; create it with implicit=True")

    def tangent(self) -> Tangent:
        """Return the exact derivatives of `residual` and of the constraints at this state.

        Computed by complex steps (Squire and Trapp, SIAM Rev. 40, 1998), column by column, with
        orientation increments on the right, q = q0 o exp(dtheta).
        """
        twin = Engine(self.model, complex_scalars=True, override=self._override)
        for name in STATE:
            getattr(twin, name)[:] = getattr(self, name).real
        nv, nrow = self.model.nv, self.model.nrow
        M, D, K, Cq = (
            np.zeros((nv, nv)),
            np.zeros((nv, nv)),
            np.zeros((nv, nv)),
            np.zeros((nrow, nv)),
        )
        moves = self.increments()
        for j in range(nv):
            for x, out in ((twin.a, M), (twin.v, D)):
                kept = x[j]
                x[j] += 1j * IMAGINARY
                out[:, j] = twin.residual().imag / IMAGINARY
                if x is twin.v:
                    Cq[:, j] = twin.constraints()[1].imag / IMAGINARY
                x[j] = kept
            kept_q = twin.q.copy()
            twin.q += 1j * IMAGINARY * moves[:, j]
            K[:, j] = twin.residual().imag / IMAGINARY
            twin.q[:] = kept_q
        return Tangent(M, D, K, Cq)

    def increments(self) -> NDArray[np.float64]:
        """Return dq (nq, nv) for unit increments [dR (world), dtheta (body frame), dp]."""
        moves = np.zeros((self.model.nq, self.model.nv))
        for b in self.model.bodies:
            rates = rates_of_parameters(self.q[b.iq + 3 : b.iq + 7].real)
            moves[b.iq : b.iq + 3, b.iv : b.iv + 3] = np.eye(3)
            moves[b.iq + 3 : b.iq + 7, b.iv + 3 : b.iv + 6] = rates
            moves[b.iq + 7 : b.iq + 7 + b.n, b.iv + 6 : b.iv + 6 + b.n] = np.eye(b.n)
        return moves

    def sensors(self) -> Scalars:
        """Return all sensor values (nout,) at the state of the last `accelerations`."""
        out = np.zeros(self.model.nout, self.dtype)
        self._library.jo_sensors(self._model, self._data, self._pointer(out))
        return out

    def native_solver(
        self,
        method: str,
        step: float,
        projection: bool,
        alpha: float = 0.0,
        beta: float = 0.0,
        **options: Any,
    ) -> Any:
        """Return a jo_solver of a method such as "rk4"; other arguments are its fields."""
        self._needs_newton()
        solver = self._ffi.new("jo_solver *")
        solver.method = kinds("jo_method")[method]
        solver.projection, solver.step = int(projection), step
        solver.alpha, solver.beta = alpha, beta
        for name, value in options.items():
            setattr(solver, name, value)
        return solver

    def meters_valid(self, memory: NDArray[np.float64]) -> bool:
        """Return whether numbers can be the memory of this model's damage meters."""
        values = np.ascontiguousarray(memory, dtype=np.float64)
        start = self._ffi.cast("double *", values.ctypes.data)
        rules = [self._model.meter[i] for i in range(len(self.model.meters))]
        return all(
            self._library.jo_meter_valid(self._ffi.addressof(rule), start + rule.at)
            for rule in rules
        )

    @property
    def native_model(self) -> Any:
        """The jo_model of this engine, for export."""
        return self._model

    def count(self, pointer: Any) -> int:
        """Return how many structs or numbers a pointer of the jo_model leads to."""
        return self._layout.count(int(self._ffi.cast("uintptr_t", pointer)))

    @property
    def bytes(self) -> int:
        """Sizes of the workspace and of a row, bytes, for programs that allocate them."""
        return int(self._library.jo_data_room(self._model)) + 8 * self.row_size

    @property
    def bytes_without_tree(self) -> int:
        """Sizes of workspace and row without joint coordinates, bytes."""
        plain = self._ffi.new("jo_model *", self._model[0])
        plain.nlink = plain.nx = plain.nu = 0
        return int(self._library.jo_data_room(plain)) + 8 * int(self._library.jo_row_size(plain))

    # -- errors -----------------------------------------------------------------------------

    def _check(self, number: int) -> None:
        if not number:
            return
        status = kind("jo_status", number)
        if status == "event":
            return
        problem = self.problem(status)
        if status in ("singular body", "friction failed"):
            raise InputError(problem)
        if status == "singular joint":
            raise SingularJoints(problem)
        body = self.model.bodies[self.error_index].name if status in AT_BODY else ""
        raise SimulationError(str(problem), time=float(self.time[0].real), body=body) from (
            self.cause if status == "callback failed" else None
        )

    @property
    def cause(self) -> BaseException | None:
        """Last exception of a user's Python function, or None."""
        return self._layout.raised[-1] if self._layout.raised else None

    def problem(self, status: str) -> Problem:
        """Return the message for a status of the engine."""
        return failure(self.model, status, self.error_index, self.cause)

    # -- memory layout ----------------------------------------------------------------------

    def _pointer(self, array: Scalars) -> Any:
        return self._ffi.from_buffer("jo_real[]", array)

    def _view(self, pointer: Any, count: int, kind: Any = None) -> Scalars:
        dtype = self.dtype if kind is None else np.dtype(kind)
        if count == 0:
            return np.zeros(0, dtype)
        address = int(self._ffi.cast("uintptr_t", pointer))
        return np.asarray(_Memory((self._data, self._layout), address, count, dtype))


class _Memory:
    """Engine memory for NumPy; it stays allocated while a view of it exists."""

    def __init__(self, owner: Any, address: int, count: int, dtype: np.dtype[Any]) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "shape": (count,),
            "typestr": dtype.str,
            "data": (address, False),
        }


def refuse_dense(model: Model) -> None:
    """Raise InputError if more bodies touch one another than Newton's matrix couples."""
    for force in model.forces:
        if force.dense:
            raise InputError(
                Problem(
                    f"contacts '{force.name}'",
                    f"{force.dense} bodies may touch one another, too many for an implicit method "
                    "or a linearisation, whose matrix couples all of them; take RK4, DormandPrince "
                    "or ROS2, or divide them into groups that are Apart",
                )
            )


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
        cross = (
            e[1] * d[2] - e[2] * d[1],  # numpy.cross is slow for single vectors
            e[2] * d[0] - e[0] * d[2],
            e[0] * d[1] - e[1] * d[0],
        )
        out[body.iq + 4 : body.iq + 7] = e0 * d + d0 * e + cross
        out[body.iq + 7 : body.iq + 7 + body.n] += dx[6:]
    return out
