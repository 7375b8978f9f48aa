"""Variants of the engine's run: another method, body frame, modal basis, or a given mechanism."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, JoustoError, JoustoWarning
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.packing.sensors import NOT_UNIQUE
from jousto.natural.comparison import FRAME, Compared, Way, sizes
from jousto.natural.rebuilt_mechanism import transfer_state, with_parts
from jousto.reduction.frames.clamp import by_mean_axes, in_frame
from jousto.reduction.frames.frame import MeanFrame, NodeFrame
from jousto.reduction.methods import FreeFree, ShapeFunctions
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import RunFailed, simulate
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.solvers.implicit import GeneralizedAlpha
from jousto.simulation.solvers.rosenbrock import ROS2
from jousto.simulation.state import State

CHEAP = 3000
"""Degrees of freedom of a part up to which a finer modal basis is computed."""
OF_FRAMES = ("modal", "deformation momentum")
"""Readings of the modes of a body, which depend on the choice of its frame."""
FOLLOWING = ("acceleration", "angular acceleration", "reaction", "multiplier", "energy")
SHAKY = (
    *("acceleration", "angular acceleration", "acceleration parts"),
    *("reaction", "multiplier", "friction"),
)
"""Readings that vibrate in modes not resolved by the step, or jump when friction sticks."""


@dataclass(frozen=True)
class Course:
    """Reference run of the engine with its settings."""

    mechanism: Mechanism
    runs: list[Solution]
    solver: Solver
    t_end: float
    output: float
    begin: Callable[[Model], State | None] | None
    typical: dict[str, float]

    def again(self, model: Model, solver: Any, state: State | None, k: int = 2) -> Solution:
        """Return a run of another model or method with the step over k."""
        step = self.solver.step / k
        return simulate(
            model,
            self.t_end,
            solver=solver if solver.adaptive else replace(solver, step=step),
            output_step=self.output,
            state=state,
        )


def differences(
    course: Course, a: list[Solution], b: list[Solution], skipped: tuple[str, ...] = ()
) -> tuple[Compared, ...]:
    """Return the differences of two pairs of runs (coarse, fine) with the same sensors."""
    kinds = {sensor.name: sensor for sensor in course.mechanism.sensors}
    return tuple(
        _difference(course, kinds[name], a, b)
        for name in a[-1]
        if name in kinds and name in b[-1] and kinds[name].reading.kind not in skipped
    )


def _difference(course: Course, sensor: Sensor, a: list[Solution], b: list[Solution]) -> Compared:
    name, kind = sensor.name, sensor.reading.kind
    about = a[-1].about(name)
    values = a[-1][name]
    size = sizes(values, list(component_units(about)), course.typical)
    kept = slice(None)
    # damage grows in jumps, whose instants differ by a few steps, so the last values are compared
    if sensor.meters:
        size = np.maximum(np.abs(values).max(axis=0, initial=0.0), 1e-300)
        size[[name.endswith("cycles") for name in about["components"]]] = np.inf
        kept = slice(-1, None)

    def off(x: Solution, y: Solution) -> float:
        n = min(len(x.time), len(y.time))  # an event may end one of the runs one output earlier
        apart: Array = np.abs(x[name][:n] - y[name][:n])[kept] / size
        return float(apart.max(initial=0.0, where=np.isfinite(apart)))

    return Compared(
        name=name,
        size=float(np.abs(a[-1][name]).max(initial=0.0)),
        unit=str(about["unit"]),
        at_instants=np.nan,
        coarse=off(a[0], b[0]) if len(a) > 1 else np.nan,
        fine=off(a[-1], b[-1]),
        unique=not str(about["description"]).endswith(NOT_UNIQUE),
        direct=kind not in FOLLOWING,
        settles=kind not in SHAKY,
        own=min(off(a[0], a[1]), off(b[0], b[1])) if len(a) > 1 else 0.0,
    )


def run_variant(name: str, make: Callable[[], tuple[Compared, ...]]) -> Way:
    """Return the differences of a variant, or why it failed; warnings are not shown."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JoustoWarning)
            return Way(name, make())
    except JoustoError as error:
        return Way(name, (), str(error).splitlines()[0])


def by_other_method(course: Course, model: Model) -> Way:
    """Return the differences from another method of the engine, at both steps."""
    other = contrasting_method(course.solver, model)
    start = course.runs[0].state(0.0)

    def make() -> tuple[Compared, ...]:
        runs = [course.again(model, other, start, k) for k in (1, 2)]
        return differences(course, course.runs, runs)

    return run_variant(method_name(other), make)


def contrasting_method(solver: Solver, model: Model) -> Any:
    """Return a method that differs from this one as much as possible."""
    if not solver.needs_tangent:
        return GeneralizedAlpha()
    # the other formulation of constraints (index 3 or projection), with more numerical damping
    if model.beams:
        index = not solver.projection
        return GeneralizedAlpha(rho=0.6, projection=index)
    return ROS2()


def method_name(solver: Any) -> str:
    """Return the name of a method in the report."""
    name = type(solver).__name__
    if not solver.needs_tangent:
        return name
    return name if solver.projection else f"{name}, index 3"


def others(course: Course, beside: Mapping[str, Mechanism]) -> Iterator[Way]:
    """Yield the variants: other body frames, a finer modal basis, and given mechanisms."""
    flexible = [b for b in course.mechanism.bodies if isinstance(b, FlexibleBody)]
    bodies = [body for body in flexible if not _framed(course.mechanism, body)]
    frames = {body: part for body in bodies if (part := in_another_frame(body)) is not None}
    if frames:
        yield run_variant(FRAME, lambda: _with(course, frames, undamped=True))
    finer = {body: part for body in bodies if (part := in_finer_basis(body)) is not None}
    if finer:
        yield run_variant("finer basis", lambda: _with(course, finer))
    for name, mechanism in beside.items():
        yield run_variant(name, lambda mechanism=mechanism: _given(course, mechanism))  # type: ignore[misc]


def _framed(mechanism: Mechanism, body: FlexibleBody) -> bool:
    """Return whether markers, joints or forces use the frame of a body itself."""
    found = [False]

    def seen(value: Any) -> bool:
        return isinstance(value, Marker) and value.body is body and value.site is None

    for item in mechanism.items:
        for name in getattr(item, "fields", {}):
            found.append(seen(getattr(item, name)))
        reading = getattr(item, "reading", None)
        if reading is not None:
            found += [seen(reading.of), seen(reading.other), seen(reading.axes)]
    return any(found)


def in_another_frame(body: FlexibleBody) -> ReducedPart | None:
    """Return the part in mean axes, or in a node frame if in mean axes; None if impossible."""
    reduced = body.reduced
    if "frame" in reduced.provenance:
        return in_frame(reduced, MeanFrame())
    places = [*reduced.interfaces, *(n for n, at in reduced.node_sets.items() if len(at) == 1)]
    for name in places:
        members = reduced.node_sets[name]
        if len(members) == 1 and reduced.rotation(members[0]) is not None:
            try:
                return in_frame(reduced, NodeFrame(name))
            except InputError:
                return None
    return None


def in_finer_basis(body: FlexibleBody) -> ReducedPart | None:
    """Return the part with free vibration modes added, as many as it has modes.

    None if its mesh is missing or too large, or if damping is given for each mode.
    """
    reduced = by_mean_axes(body.reduced) if body.reduced.source is not None else body.reduced
    part = reduced.source
    if part is None or part.K.shape[0] > CHEAP or part.ties or np.ndim(body.damping):
        return None
    room = part.K.shape[0] - 6 - reduced.n
    if room < reduced.n:
        return None
    try:
        free = reduce(part, FreeFree(modes=reduced.n), cache=False)
        columns = [_columns(one, part.dofs_per_node) for one in (reduced, free)]
        method = ShapeFunctions(np.hstack(columns))
        return reduce(part, method, stiffening=reduced.stiffening is not None, cache=False)
    except InputError:
        return None


def _columns(reduced: ReducedPart, each: int) -> Array:
    """Return the modes in the degrees of freedom of the part."""
    rows = [reduced.modes]
    if each == 6:
        assert reduced.rotations is not None
        rows.append(reduced.rotations)
    return np.concatenate(rows, axis=1).reshape(-1, reduced.n)


def _with(
    course: Course, parts: Mapping[FlexibleBody, ReducedPart], undamped: bool = False
) -> tuple[Compared, ...]:
    """Return the differences from a run with other parts in bodies, optionally undamped."""
    own, run = course.mechanism, course.runs[-1]
    items = [item for item in own.items if not getattr(item, "meters", ())]
    if len(items) < len(own.items):
        own = Mechanism(*items, name=own.name, core=own.core)
    start = course.runs[0].state(0.0)
    if undamped and any(body.modal_damping.any() for body in parts):
        own = with_parts(own, {body: body.reduced for body in parts}, damping=0.0)
        run = course.again(compile(own), course.solver, replace(start, work=None))
        names = {body.name: part for body, part in parts.items()}
        parts = {b: names[b.name] for b in own.bodies if b.name in names}  # type: ignore[misc]
    other = with_parts(own, parts)
    model, state = compile(other), transfer_state(start, own, other)
    try:
        found = course.again(model, course.solver, state)
    except RunFailed:  # faster modes may need another method, which `simulate` chooses
        chosen = choose(model, course.t_end, course.output)[0]
        if type(chosen) is type(course.solver):
            raise
        found = course.again(model, chosen, state)
    return differences(course, [run], [found], OF_FRAMES)


def _given(course: Course, mechanism: Mechanism) -> tuple[Compared, ...]:
    """Return the differences between the run and that of a given mechanism, for equal sensors."""
    model = compile(mechanism)
    state = None if course.begin is None else course.begin(model)
    return differences(course, course.runs[-1:], [course.again(model, course.solver, state)])
