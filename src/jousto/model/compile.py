"""Conversion of a mechanism, objects with references, to a model of flat arrays."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.complexstep import floats, is_stepping
from jousto.base.errors import InputError, NotAnalytic, Problem, count, warn
from jousto.base.garbage_collection import uncollected
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.checks import coordinates_of, used_joints
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.initial import Initial
from jousto.mechanism.joints.base import align_frames
from jousto.mechanism.mechanism import Mechanism
from jousto.model.elimination_order import MOST, Elimination, TooDense
from jousto.model.frame_record import frame_shape
from jousto.model.hubs import joints_on, order_joints
from jousto.model.initial_conditions import held_lines, quiet_velocities, started
from jousto.model.likeness import Likeness
from jousto.model.mode_loads import ModeLoads, mode_loads
from jousto.model.model import BodyModel, Model, Shape
from jousto.model.moved_bodies import warn_moved
from jousto.model.native.layout import share_layout
from jousto.model.native.native import Engine, SingularJoints
from jousto.model.overlaps import apart_sets, refuse_overlaps
from jousto.model.packing.bodies import beam_models, beam_shapes, warn_beams, warn_bodies
from jousto.model.packing.builder import Builder
from jousto.model.packing.events import event_models, watched_coordinates
from jousto.model.packing.foreign import fmu_models
from jousto.model.packing.sensors import NOT_UNIQUE, flag_reactions, meter_models, sensor_models
from jousto.model.rank.redundancy import check_closed, is_drive, repeated_rows
from jousto.model.scales import largest_speed, velocity_metres
from jousto.model.start_complex_step import with_start
from jousto.model.symbol_record import Symbols, SymbolShape
from jousto.model.tree import with_core
from jousto.reduction.stress_sites import located

if TYPE_CHECKING:
    from jousto.reduction.fields.stress import StressModes
    from jousto.reduction.reduced import ReducedPart

log = logging.getLogger(__name__)
CHANGED = 1e-6  # smallest change of velocities that is reported, relative to the largest velocity
SYMMETRIC = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))  # indices of xx yy zz yz xz xy
ROWS, COLUMNS = (list(places) for places in zip(*SYMMETRIC, strict=True))
NO_MODES: dict[str, Any] = {
    **{key: np.zeros((rows, 0)) for key, rows in (("I3", 3), ("B0", 3), ("D0", 6))},
    **{key: np.zeros((rows, 0, 0)) for key, rows in (("ED", 6), ("EB", 3))},
    **{key: np.zeros(0) for key in ("K", "D")},
}
"""Modal arrays of a body without modes."""


@uncollected()
@explained
def compile(mechanism: Mechanism, *, core: str | None = None) -> Model:
    """Return the flat arrays of a mechanism for the engine, with a consistent initial state.

    Small gaps at joints are closed by projection in the mass metric. Initial velocities that
    violate joints or drives are corrected by rigid motions of least kinetic energy, and by modal
    velocities only as far as necessary: a machine with drives in motion starts like the rigid
    mechanism, without exciting its modes. Values and rates of coordinates (`Initial`) are reached
    in the same way.

    Parameters
    ----------
    mechanism : Mechanism
        A checked mechanism.
    core : str, optional
        Coordinates of all but implicit solvers: "joint" for the joint coordinates of a tree of
        rigid bodies (in mechanisms with flexible bodies, for rigid subtrees; not DormandPrince);
        "maximal" for the positions of all bodies, for any mechanism; "auto" for the faster one.
        None for the core of the mechanism.

    Returns
    -------
    Model
        Flat arrays, for any number of runs.

    Raises
    ------
    InputError
        If the mass matrix of a body is singular, joints, couplings and drives contradict each
        other, an initial value cannot be reached, shapes that overlap are refused or cannot be
        moved apart, or the requested joint coordinates are impossible.

    Warns
    -----
    JoustoWarning
        If the initial value of a drive differs from its coordinate, so that bodies are moved;
        initial velocities contradict the joints and were changed; constraints are redundant, so
        that their reactions are not unique; or almost all mass of a flexible body lies on a line,
        so that its modes cannot represent its rotation about the line.
    """
    model, builder = pack(mechanism)
    return finish(model, builder, mechanism, mechanism.core if core is None else core)


def pack(mechanism: Mechanism) -> tuple[Model, Builder]:
    """Return the flat arrays of a mechanism at its declared pose, and the builder of its objects.

    The result has no consistent initial state and no links of a tree yet, see `finish`.
    """
    warn_parts(mechanism)
    index = {id(body): i for i, body in enumerate(mechanism.bodies)}
    bodies, q0, v0 = _bodies(mechanism)
    builder = Builder(index, mechanism.events)
    used = used_joints(mechanism)
    align_frames(mechanism.joints)
    for joint in mechanism.joints:
        builder.joint(joint, used=id(joint) in used)
    for coupling in mechanism.couplings:
        builder.coupling(coupling)
    for load in mechanism.forces:
        builder.force(load)
    builder.states(mechanism)
    watched = watched_coordinates(mechanism)
    gauges = (*mechanism.sensors, *watched)
    for sensor in gauges:  # angle coordinates are tracked over full turns at every step
        for coordinate in coordinates_of(sensor):
            builder.declared(coordinate)
    for initial in mechanism.initials:
        builder.declared(initial.coordinate)
    # couplings follow the joints
    places = {id(x): i for i, x in enumerate((*mechanism.joints, *mechanism.couplings))}
    for friction in mechanism.frictions:  # these rows follow all permanent rows
        builder.friction(friction, places[id(friction.joint)])
    for contact in mechanism.forces:
        if isinstance(contact, Contact) and contact.sticks:
            builder.sticking(contact)
    active = len(builder.markers)
    sensors = sensor_models(mechanism, builder, index, watched)
    builder.events += event_models(mechanism, gauges, sensors)
    model = Model(
        name=mechanism.name,
        gravity=np.array(floats(mechanism.gravity)),
        bodies=bodies,
        markers=tuple(builder.markers),
        active=active,
        joints=tuple(builder.joints),
        signals=tuple(builder.signals),
        forces=tuple(builder.forces),
        sensors=sensors,
        elimination=_elimination(mechanism, builder, bodies),
        q0=q0,
        v0=v0,
        shapes=tuple(shape_of(body) for body in mechanism.bodies),
        size=mechanism.size,
        coordinates=tuple(builder.coordinates),
        frictions=tuple(builder.frictions),
        redundant=sum(friction.contact >= 0 for friction in builder.frictions) > 1,
        switched=tuple(builder.switched),
        events=tuple(builder.events),
        meters=meter_models(mechanism, sensors),
        beams=beam_models(mechanism, index),
        beam_shapes=beam_shapes(mechanism, index),
        mode_loads=ModeLoads() if is_stepping() else mode_loads(mechanism),
        symbols=() if is_stepping() else _symbols(mechanism, index),
        fmus=fmu_models(mechanism, sensors),
        start=mechanism.start,
    )
    return model, builder


def warn_parts(mechanism: Mechanism) -> None:
    """Warn about beams and flexible bodies whose formulation does not fit."""
    if not is_stepping():
        warn_beams(mechanism)
        warn_bodies(mechanism)


def finish(
    model: Model,
    builder: Builder,
    mechanism: Mechanism,
    core: str,
    *,
    like: Likeness | None = None,
    keep: list[Model] | None = None,
    initials: Sequence[Initial] | None = None,
) -> Model:
    """Return a packed model with its consistent initial state and its solver core.

    Parameters
    ----------
    model : Model
        From `pack`; its initial state is replaced.
    builder : Builder
        Builder with the coordinates of the model.
    mechanism : Mechanism
        The mechanism.
    core : str
        Solver core, see `compile`.
    like : Likeness, optional
        Models of a mechanism that differs in numbers only.
    keep : list, optional
        The model without links is appended to it.
    initials : sequence of Initial, optional
        Values and rates at coordinates of the builder; by default those of the mechanism.
    """
    placed, given = model.q0.copy(), model.v0.copy()
    initials = mechanism.initials if initials is None else initials

    def finished(model: Model) -> Model:
        begun = started(model, initials, builder) if initials else model
        return _consistent(begun)

    if is_stepping() and apart_sets(mechanism):
        raise NotAnalytic("shapes that overlap are moved apart by iterations")
    made = with_start(model, finished, initials) if is_stepping() else finished(model)
    if not is_stepping():
        warn_moved(mechanism, made, placed)
        if apart_sets(mechanism):
            from jousto.model.pushed_apart import pushed_apart

            values = [initial for initial in initials if initial.value is not None]
            apart = pushed_apart(mechanism, made, held_lines(values, builder))
            if apart is not made:
                made = finished(replace(apart, q0=np.array(apart.q0), v0=given))
        refuse_overlaps(mechanism, made)
    closed = made
    if keep is not None:
        keep.append(closed)
    if like is not None and like.fits(closed):
        made = like.with_links(closed)
    else:
        made = with_core(closed, core)
        share_layout(made, closed)
    log.info(
        "%s: %d velocities, %d constraint rows%s",
        *(made.name, made.nv, made.nrow, ", some repeated" if made.redundant else ""),
    )
    return made


def _elimination(
    mechanism: Mechanism, builder: Builder, bodies: Sequence[BodyModel]
) -> Elimination:
    """Return the elimination order of the joints; InputError for too many coupled joints."""
    try:
        return order_joints(builder.joints, builder.markers, bodies, most=MOST)
    except TooDense as error:
        found, dense = f"mechanism {mechanism.name!r}", error
    cost = f"{dense.products:.2g} products of blocks at each evaluation, {MOST:.2g} at the most"
    for body, joints in joints_on(builder.joints, builder.markers).items():
        if dense.clique and tuple(joints) == dense.clique:
            found = f"body '{mechanism.bodies[body].name}'"
            reason = f"has {count(len(joints), 'joint')}, which are all coupled with one another"
            remedy = (
                "divide it into several bodies, each fixed to the previous one, with at most "
                "some hundred joints each"
            )
            break
    else:
        reason = "has so many loops that a large part of its joints is coupled with one another"
        remedy = "leave out joints that close loops, or merge bodies with little relative motion"
    raise InputError(Problem(found, f"{reason} ({cost}); {remedy}"))


def _symbols(mechanism: Mechanism, index: Mapping[int, int]) -> Symbols:
    """Return the symbols of a mechanism, which are made when it is drawn."""

    def make() -> tuple[SymbolShape, ...]:
        from jousto.model.symbols import symbols

        return symbols(mechanism, index)

    return Symbols(mechanism.name, make)


def _bodies(mechanism: Mechanism) -> tuple[tuple[BodyModel, ...], Array, Array]:
    models: list[BodyModel] = []
    q: list[Array] = []
    v: list[Array] = []
    iq = iv = 0
    parts: dict[tuple[int, frozenset[str]], BodyModel] = {}
    rigid = _inertias([body for body in mechanism.bodies if not isinstance(body, FlexibleBody)])
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody):
            kind = (id(body.reduced), body.drop_invariants)
            if kind not in parts:  # bodies with the same part share its arrays
                parts[kind] = _flexible(body, 0, 0)
            D = np.array(floats(body.modal_damping))
            model = replace(parts[kind], name=body.name, iq=iq, iv=iv, D=D)
        else:
            model = _rigid(body, iq, iv, *next(rigid))
        models.append(model)
        iq += 7 + model.n
        iv += 6 + model.n
        w = body.angular_velocity
        if w.any():
            w = rotation_matrix(body.orientation).T @ w
        q += [body.position, body.orientation, body.modal_coordinates]
        v += [body.velocity, w, body.modal_velocities]
    empty = np.zeros(0)
    return tuple(models), np.concatenate([empty, *q]), np.concatenate([empty, *v])


def _inertias(bodies: Sequence[RigidBody]) -> Iterator[tuple[Array, Array, Array]]:
    """Return mass (1,), first moment (3,) and inertia (6,) about the origin of each body."""
    m = floats([body.mass for body in bodies]).reshape(-1, 1)
    c = floats([body.center for body in bodies]).reshape(-1, 3)
    J = floats([body.inertia for body in bodies]).reshape(-1, 3, 3)
    squares = (c * c).sum(axis=1)[:, None, None] * np.eye(3) - c[:, :, None] * c[:, None, :]
    J = J + m[..., None] * squares  # parallel-axis theorem
    return zip(m, m * c, J[:, ROWS, COLUMNS], strict=True)


def _rigid(body: RigidBody, iq: int, iv: int, mass: Array, S0: Array, J0: Array) -> BodyModel:
    return BodyModel(
        name=body.name,
        iq=iq,
        iv=iv,
        mass=mass,
        S0=S0,
        J0=J0,
        **NO_MODES,
        alpha=body.damping if isinstance(body, BeamNode) else 0.0,
    )


def rigid_model(body: RigidBody, iq: int, iv: int) -> BodyModel:
    """Return the arrays of one rigid body, with its offsets in q and v."""
    return _rigid(body, iq, iv, *next(_inertias([body])))


def half_inertia_rate(N: Array) -> Array:
    """Return ``tr(N) E - sym(N)`` as xx yy zz yz xz xy on the first axis; N (..., 3, 3)."""
    trace = np.trace(N, axis1=-2, axis2=-1)
    return np.stack(
        [(trace if i == j else 0.0) - 0.5 * (N[..., i, j] + N[..., j, i]) for i, j in SYMMETRIC]
    )


def axial(N: Array) -> Array:
    """Return ``int a x b dm`` from ``N = int a b^T dm``, on the first axis; N (..., 3, 3)."""
    return np.stack(
        [
            N[..., 1, 2] - N[..., 2, 1],
            N[..., 2, 0] - N[..., 0, 2],
            N[..., 0, 1] - N[..., 1, 0],
        ]
    )


def _flexible(body: FlexibleBody, iq: int, iv: int) -> BodyModel:
    inv = body.reduced.invariants
    J = np.trace(inv.second_moment) * np.eye(3) - inv.second_moment
    # N_j(p) = N0_j + sum_k p_k E_kj
    E = np.swapaxes(inv.E, 0, 1)
    ED, EB = half_inertia_rate(E), axial(E)
    if "I9" in body.drop_invariants:
        ED = np.zeros_like(ED)
    if "I5" in body.drop_invariants:
        EB = np.zeros_like(EB)
    if body.reduced.stiffening is not None:
        # int u0 chi^T dm; its axial part and int chi dm vanish by the choice of chi
        ED = ED + half_inertia_rate(body.reduced.stiffening.second_moment)
    return BodyModel(
        name=body.name,
        iq=iq,
        iv=iv,
        mass=np.array(floats([inv.mass])),
        S0=np.array(floats(inv.first_moment)),
        J0=np.array([J[i, j] for i, j in SYMMETRIC]),
        I3=np.array(floats(inv.I3)),
        B0=axial(inv.N0),
        D0=half_inertia_rate(inv.N0),
        ED=ED,
        EB=EB,
        K=np.array(floats(body.reduced.stiffness)),
        D=np.zeros(len(body.reduced.stiffness)),
        stiffening=body.reduced.stiffening is not None,
    )


def part_shape(reduced: ReducedPart) -> Shape:
    """Return the data of a part that results contain to draw its bodies."""
    return Shape(
        "flexible",
        np.array(floats(reduced.nodes)),
        np.array(reduced.elements, dtype=np.int64),
        np.array(floats(reduced.modes)),
        _stress(reduced),
        frame_shape(reduced),
    )


def shape_of(body: RigidBody | FlexibleBody) -> Shape:
    """Return the drawing of a body."""
    if isinstance(body, FlexibleBody):
        return part_shape(body.reduced)
    points = body.outline
    if points is not None and points.ndim == 3:  # a closed surface
        nodes, corners = np.unique(points.reshape(-1, 3), axis=0, return_inverse=True)
        triangles = corners.reshape(-1, 3).astype(np.int64)
        return Shape("rigid", nodes, triangles, np.zeros((len(nodes), 3, 0)))
    if (
        points is None
    ):  # no outline: lines from the centre of mass to the origin and the named points
        points = floats([body.center, (0.0, 0.0, 0.0), *body.markers.values()])
        elements = np.zeros((len(points) - 1, 2), np.int64)
        elements[:, 1] = range(1, len(points))
    else:
        elements = np.array([[i, i + 1] for i in range(len(points) - 1)], dtype=np.int64)
    nodes = np.array(floats(points))
    return Shape("rigid", nodes, elements.reshape(-1, 2), np.zeros((len(nodes), 3, 0)))


def _stress(reduced: ReducedPart) -> StressModes | None:
    """Return the stress data stored in results: all sites, for solids only those on the surface."""
    stress = located(reduced)
    if stress is None or reduced.elements.ndim != 2 or reduced.elements.shape[1] != 3:
        return stress
    assert stress.nodes is not None
    # reference nodes of interfaces have no stress and belong to no element
    turning = reduced.rotation_nodes
    bulk = len(reduced.nodes) - (0 if turning is None else len(turning))
    if len(np.unique(stress.nodes[stress.nodes >= 0])) < bulk:
        return stress  # selected sites
    return stress.select(np.flatnonzero(np.isin(stress.nodes, np.unique(reduced.elements))))


def _consistent(model: Model) -> Model:
    """Return the model after closing its joints, with velocities that satisfy them."""
    engine = Engine(model, strict=True, implicit=False)
    given = model.v0.copy()
    found = None
    try:
        engine.assemble()
        engine.accelerations()  # reports singular bodies and redundant rows
    except SingularJoints:
        _check_reachable(model)
        if not (found := repeated_rows(model)):
            raise  # the rows are independent, but the masses differ beyond double precision
        every = tuple(joint.name for joint in model.joints)
        rubbing = tuple(friction.joint for friction in model.frictions)
        flagged = flag_reactions(model.sensors, every, found.joints, rubbing)
        model = replace(model, redundant=True, sensors=flagged)
        engine = Engine(model, implicit=False)
        engine.assemble()
        engine.accelerations()
    check_closed(model, engine, found)
    if found:
        asked = [f"'{s.name}'" for s in model.sensors if s.description.endswith(NOT_UNIQUE)]
        tail = f"; {', '.join(asked)} depend on these reactions" if asked else ""
        warn(f"mechanism {model.name!r}", found.sentence + tail)
    elif model.permanent == model.nv and not any(
        is_drive(joint) or joint.release >= 0 for joint in model.joints
    ):
        warn(
            f"mechanism {model.name!r}",
            f"nothing can move: its {count(model.permanent, 'constraint row')} prevent every "
            f"motion; free a motion of a joint, or add a body that can move; doctor(mechanism) "
            f"lists the fixed bodies",
        )
    if found:
        for friction in model.frictions:
            if (joint := model.joints[friction.joint].name) in found.joints:
                warn(
                    f"friction '{friction.name}'",
                    f"the reactions of joint '{joint}' are not unique, so neither is its friction "
                    f"(used: the reactions of least norm); free a motion of the loop or make a "
                    f"body flexible",
                )
    quiet = quiet_velocities(model, engine, given)
    model.q0[:] = engine.q
    model.v0[:] = engine.v if quiet is None else quiet
    model.q0.setflags(write=False)
    model.v0.setflags(write=False)
    names = "" if model.v0.tobytes() == given.tobytes() else _changed(model, given)
    if names and not any(line.signal >= 0 for joint in model.joints for line in joint.lines):
        warn(
            f"mechanism {model.name!r}",
            f"the initial velocities of {names} contradict the joints; "
            "they were replaced by the nearest consistent ones",
        )
    return model


def _check_reachable(model: Model) -> None:
    """Raise InputError if assembly stops at a position with open joints."""
    engine = Engine(replace(model, redundant=True), implicit=False)
    try:
        engine.assemble()
    except SingularJoints:
        check_closed(model, engine, None)


def _changed(model: Model, given: Array) -> str:
    """Return the bodies whose initial velocities were changed."""
    change = np.abs(model.v0 - given) * velocity_metres(model)
    tolerance = CHANGED * max(largest_speed(model, given), largest_speed(model, model.v0))
    names: Iterable[str] = (
        f"'{body.name}'"
        for body in model.bodies
        if change[body.iv : body.iv + 6 + body.n].max() > tolerance
    )
    return ", ".join(names)
