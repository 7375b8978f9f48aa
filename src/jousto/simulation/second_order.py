"""Geometric stiffness of modal bodies that were reduced without stiffening."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problems, warn
from jousto.base.rotations import exp_rotation
from jousto.base.rounding import SHARE
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.model.compile import half_inertia_rate
from jousto.model.model import BodyModel, MarkerModel, Model, Shape
from jousto.model.native.native import Engine
from jousto.reduction.frames.stiffened import stiffened
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.check_spin import spins
from jousto.simulation.state import State, put

CHEAP = 3000
"""Degrees of freedom of a part up to which its geometric stiffness is computed in any case."""
ASKED = 1e-3
"""Estimated change of the stiffness over the stiffness, above which the geometric stiffness of a
larger part is computed. The estimate may be four times too low (cantilever, axial load)."""
NOTICED = 0.02
"""Relative change of the stiffness above which a linear body is warned of: 1 % of a frequency."""
SPUN = 0.03
"""Spin over the lowest frequency with the same meaning: its square is a change of the stiffness."""

# xx yy zz yz xz xy: the six strains of a body
STRAINS = np.zeros((6, 3, 3))
for _k, (_i, _j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
    STRAINS[_k, _i, _j] += 0.5
    STRAINS[_k, _j, _i] += 0.5

_MADE: WeakKeyDictionary[Model, tuple[Model, dict[int, InputError]]] = WeakKeyDictionary()


def with_second_order(model: Model, where: str) -> Model:
    """Return the model with geometric stiffness in all its modal bodies.

    Raises
    ------
    InputError
        With each body whose part has no geometric stiffness, and the remedy.
    """
    given: object = model
    if not isinstance(given, Model):
        return model  # the caller raises the error of a wrong type
    made, refused = _second_order(model, linear_bodies(model))
    problems = Problems()
    for index, error in refused.items():
        problems.add(
            f"{where}: body '{model.bodies[index].name}'",
            "is linear, so that loads do not change its stiffness, and its second-order "
            f"displacements cannot be computed here: its part {error.problems[0].sentence}",
        )
    problems.raise_if_any()
    return made


def where_noticed(model: Model, state: State | None, where: str) -> Model:
    """Return the model with geometric stiffness in bodies whose stiffness the loads change.

    Bodies of parts up to CHEAP degrees of freedom always get it; for larger parts the change of the
    stiffness is estimated first.

    Warns
    -----
    JoustoWarning
        If loads change the stiffness of a body that remains linear.
    """
    parts = linear_bodies(model)
    if not parts:
        return model
    large = {k for k, part in parts.items() if part.source is None or _is_large(part)}
    shares = stiffness_shares(model, state, large) if large else {}
    wanted = {k: part for k, part in parts.items() if shares.get(k, 1.0) > ASKED}
    made, refused = _second_order(model, wanted)
    for index, error in refused.items():
        share = shares.get(index, 0.0)
        if share > NOTICED:
            warn(
                where,
                f"body '{model.bodies[index].name}' is linear, but its loads change its stiffness "
                f"by about {100.0 * share:.2g} %, which is neglected: its part "
                f"{error.problems[0].sentence}",
            )
    return made


def as_in(model: Model, other: Model, state: State) -> Model:
    """Return a model with geometric stiffness in the bodies that have it in another model.

    Bodies without load at a state of the other model are left linear, with the same result.
    """
    parts = linear_bodies(model)
    both = {k for k in parts if other.bodies[k].stiffening}
    shares = stiffness_shares(other, state, both) if both else {}
    return _second_order(model, {k: parts[k] for k, x in shares.items() if x > SHARE})[0]


def linear_bodies(model: Model) -> dict[int, ReducedPart]:
    """Return the parts of the modal bodies without geometric stiffness, by the index of the body.

    Bodies without any load or joint are left out.
    """
    found: dict[int, ReducedPart] = {}
    for marker in model.markers:
        if marker.body >= 0 and marker.site is not None:
            b = model.bodies[marker.body]
            if b.n and not b.stiffening and isinstance(marker.site.body, FlexibleBody):
                found[marker.body] = marker.site.body.reduced
    return found


def _is_large(part: ReducedPart) -> bool:
    assert part.source is not None
    return bool(part.source.K.shape[0] > CHEAP)


def _second_order(
    model: Model, parts: dict[int, ReducedPart]
) -> tuple[Model, dict[int, InputError]]:
    """Return the model with geometric stiffness in bodies, and the errors of the other bodies."""
    found: dict[int, ReducedPart] = {}
    refused: dict[int, InputError] = {}
    for index, part in parts.items():
        try:
            found[index] = stiffened(part)
        except InputError as error:
            refused[index] = error
    if not found:
        return model, refused
    kept = _MADE.get(model)
    if kept is not None and all(kept[0].bodies[k].stiffening for k in found):
        return kept[0], refused
    bodies = tuple(
        _stiffening_body(body, found[k]) if k in found else body
        for k, body in enumerate(model.bodies)
    )
    markers = tuple(
        _stiffening_marker(marker, found[marker.body]) if marker.body in found else marker
        for marker in model.markers
    )
    _MADE[model] = replace(model, bodies=bodies, markers=markers), refused
    return _MADE[model]


def _stiffening_body(body: BodyModel, part: ReducedPart) -> BodyModel:
    assert part.stiffening is not None
    ED = body.ED + half_inertia_rate(part.stiffening.second_moment)
    return replace(body, ED=ED, stiffening=True)


def _stiffening_marker(marker: MarkerModel, part: ReducedPart) -> MarkerModel:
    if marker.site is None or marker.site.site is None:
        return marker
    return replace(marker, chi=marker.site.second_order(part))


def stiffness_shares(model: Model, state: State | None, indices: set[int]) -> dict[int, float]:
    """Return the estimated relative change of the stiffness of bodies by the loads at a state.

    The integral of the stress over a body is ``W = int sigma dV = sum f (x) u + int g (x) u dm``,
    with the forces f at the points u (virial theorem). A slender body under a principal value of W
    along its axis e has the geometric stiffness ``N int w'^2 dx = (e W e) mean(w'^2)``, where w' is
    the slope of element edges along e. The change is the largest eigenvalue of this matrix over
    ``diag(omega^2)``, or the square of the spin over the lowest frequency.

    Parameters
    ----------
    model : Model
    state : State or None
        None: the initial state.
    indices : set of int
        Indices of the bodies.

    Returns
    -------
    dict of int to float
        Relative change by the index of the body.
    """
    engine = Engine(model)
    if state is not None:
        put(engine, state, "second order")
    row = np.concatenate([[0.0], engine.q, engine.v])[None]
    rates = {spin.index: spin.share(spin.squared(row)) for spin in spins(model)}
    engine.v[:] = 0.0
    engine.accelerations()
    W = mean_stresses(model, engine, indices)
    shares = {}
    for k in indices:
        turning = rates.get(k, 0.0)
        along = _share(model.bodies[k], model.shapes[k], W[k])
        shares[k] = max(along, turning**2 if turning > SPUN else 0.0)
    return shares


def mean_stresses(model: Model, engine: Engine, indices: set[int]) -> dict[int, Array]:
    """Return ``int sigma dV`` (3, 3), body frame, J, of bodies at the state of an engine.

    It is the virtual work of the loads of the engine in six uniform strains H, which replace the
    modes of a body by the displacements ``H (u0 + Phi p)``.
    """
    found = {k: np.zeros((3, 3)) for k in indices}
    n = min(model.bodies[k].n for k in indices)
    for first in range(0, len(STRAINS), n):
        strains = STRAINS[first : first + n]
        variant = Engine(_strained(model, engine, indices, strains))
        variant.q[:], variant.lam[:], variant.input[:] = engine.q, engine.lam, engine.input
        variant.time[0] = engine.time[0]
        variant.a[:] = 0.0
        for k in indices:
            b = model.bodies[k]
            variant.q[b.iq + 7 : b.iq + 7 + b.n] = 0.0
            variant.a[b.iv : b.iv + 3] = engine.a[b.iv : b.iv + 3]
        r = variant.residual()
        for k in indices:
            b = model.bodies[k]
            for H, work in zip(strains, r[b.iv + 6 : b.iv + 6 + len(strains)], strict=True):
                found[k] -= work * H / (H * H).sum()
    return found


def _strained(model: Model, engine: Engine, indices: set[int], strains: Array) -> Model:
    """Return the model with uniform strains in place of the modes of bodies."""
    m = len(strains)
    bodies, markers = list(model.bodies), list(model.markers)
    p = {k: engine.q[b.iq + 7 : b.iq + 7 + b.n] for k, b in enumerate(model.bodies)}
    for k in indices:
        b = bodies[k]
        S0 = b.S0 + b.I3 @ p[k]
        I3 = np.zeros_like(b.I3)
        I3[:, :m] = (strains @ S0).T
        empty = {name: np.zeros_like(getattr(b, name)) for name in ("B0", "D0", "ED", "EB", "K")}
        bodies[k] = replace(b, S0=S0, I3=I3, **empty)
    for i, marker in enumerate(markers):
        if marker.body not in indices:
            continue
        Phi = np.zeros((3, model.bodies[marker.body].n))
        u0, A0 = marker.u0, marker.A0
        if marker.Phi is not None:
            u0 = u0 + marker.Phi @ p[marker.body]
        if marker.Psi is not None:
            A0 = exp_rotation(marker.Psi @ p[marker.body]) @ A0
        Phi[:, :m] = (strains @ u0).T
        Psi = None if marker.Psi is None else np.zeros_like(marker.Psi)
        markers[i] = replace(marker, u0=u0, A0=A0, Phi=Phi, Psi=Psi)
    forces = tuple(
        replace(f, data=np.zeros_like(f.data)) if f.kind == "modal load" else f
        for f in model.forces
    )
    return replace(model, bodies=tuple(bodies), markers=tuple(markers), forces=forces)


def _share(body: BodyModel, shape: Shape, W: Array) -> float:
    """Return the largest ratio of the geometric stiffness due to W and the modal stiffness."""
    ends = np.asarray(shape.elements)
    if not ends.size:
        return 0.0
    pairs = np.stack([ends, np.roll(ends, -1, axis=1)], axis=2).reshape(-1, 2)
    a, b = pairs[pairs[:, 0] != pairs[:, 1]].T
    d = shape.nodes[b] - shape.nodes[a]
    length = np.linalg.norm(d, axis=1)
    d, a, b, length = (x[length > 0.0] for x in (d, a, b, length))
    d = d / length[:, None]
    slope = (shape.modes[b] - shape.modes[a]) / length[:, None, None]
    slope = slope - np.einsum("ea,eb,ebj->eaj", d, d, slope)
    Kg = np.zeros((body.n, body.n))
    pulls, axes = np.linalg.eigh(W)
    for pull, e in zip(pulls, axes.T, strict=True):
        weight = length * (d @ e) ** 2
        total = float(weight.sum())
        if total > 0.0:
            weighted = (weight / total)[:, None, None] * slope
            Kg += pull * np.tensordot(weighted, slope, ((0, 1), (0, 1)))
    scale = 1.0 / np.sqrt(body.K)
    return float(np.abs(np.linalg.eigvalsh(scale[:, None] * Kg * scale)).max(initial=0.0))
