"""clamp, in_frame: a part held by supports; a flexible body relative to another frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import singledispatch
from typing import Any, overload

import numpy as np
import scipy.linalg as la

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.parts.part import Part
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.frames.frame import ChordFrame, Frame, MeanFrame, NodeFrame
from jousto.reduction.frames.stiffening_transform import Turn, turned_stiffening
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.supports.support import Clamp, SpringSupport, Support, marker_hint
from jousto.reduction.supports.supported import SupportedPart

SHORT = 1e-9
"""Smallest length of a chord / size of the part."""

CLAMPED = "clamped"
"""Key of the provenance of a reduced part: the node at which `clamp` holds it."""


# a str is a sequence of str, too: the first overload takes precedence
@overload
def clamp(part: ReducedPart, supports: str) -> ReducedPart: ...  # type: ignore[overload-overlap]
@overload
def clamp(
    part: Part | ReducedPart,
    supports: Support | Sequence[str | Support],
    *,
    solver: str | None = None,
) -> SupportedPart: ...
@explained
def clamp(part: Any, supports: Any, *, solver: str | None = None) -> ReducedPart | SupportedPart:
    """Return a part held by clamps and springs at any number of nodes.

    A reduced part and the name of one node give a reduced part again, a body of machines whose
    frame is that node: ``in_frame(part, NodeFrame(node))``, with modes that vanish there. All other
    supports give a `SupportedPart` with its modes, static states and reactions.

    Parameters
    ----------
    part : Part or ReducedPart
        The part. Supports of a reduced part are on its interfaces.
    supports : str, Clamp, SpringSupport or sequence of them
        Supports of the part. The name of a node or set stands for a clamp in all its directions.
        Supports may be statically indeterminate.
    solver : str, optional
        Library that factorises the stiffness of a full part, see `solvers`.

    Returns
    -------
    ReducedPart or SupportedPart
        The reduced part has the same number of modes, sorted by their clamped frequencies.

    Raises
    ------
    InputError
        With all problems: unknown nodes, directions that a node does not have or that two clamps
        hold, nodes of a reduced part that are not interfaces, a part that is already clamped. Also
        if no support holds a rigid motion, or only springs below the rounding error of the
        stiffness of the part; the message contains its name.

    Examples
    --------
    A steel cantilever of 20 x 10 mm; slender beam theory gives 8.3552 Hz:

    >>> import jousto as jo
    >>> from jousto.reduction import Clamp, clamp
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, steel)
    >>> rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))
    >>> clamp(rod, "start").frequencies[0].round(2)
    np.float64(8.35)

    Clamped at one end and pinned at the other, 4.3851 times as high:

    >>> propped = clamp(part, [Clamp("start"), Clamp("end", "x y z")])
    >>> (propped.modes(1).frequencies[0] / 8.3552).round(2)
    np.float64(4.38)
    """
    if not isinstance(part, Part | ReducedPart):
        message = f"part is {part!r}, must be a Part or a ReducedPart"
        if isinstance(part, SupportedPart):
            message += "; list all supports together: clamp(part, [...])"
        raise InputError(Problem("clamp", message))
    if isinstance(part, ReducedPart) and CLAMPED in part.provenance:
        raise InputError(_clamped_again(part, supports))
    if isinstance(part, ReducedPart) and isinstance(supports, str):
        held = in_frame(part, NodeFrame(supports))
        return replace(held, provenance={**held.provenance, CLAMPED: supports})
    given = [supports] if isinstance(supports, str | Support) else supports
    problems = Problems()
    if marker_hint(given):
        given = [given]
    if not isinstance(given, Iterable):
        problems.add("clamp", f"supports is {supports!r}, must be Clamp, SpringSupport or a list")
        problems.raise_if_any()
    chosen = [Clamp(x) if isinstance(x, str) else x for x in given]
    for x in chosen:
        if not isinstance(x, Clamp | SpringSupport):
            wanted = marker_hint(x) or "must be a name, Clamp or SpringSupport"
            problems.add("clamp", f"support {x!r} {wanted}")
    problems.raise_if_any()
    return SupportedPart(part, chosen, solver=solver)


def _clamped_again(part: ReducedPart, supports: Any) -> Problem:
    """Return the error for a part whose modes belong to the frame of a clamped node already."""
    first = part.provenance[CLAMPED]
    given = [supports] if isinstance(supports, str | Support) else supports
    further = given if isinstance(given, list | tuple) else ()
    names = [x for x in further if isinstance(x, str) and x != first]
    rest = [repr(x) for x in names] if names and len(names) == len(further) else ["..."]
    return Problem(
        f"reduced part '{part.name}'",
        f"is already clamped at {first!r}, which another clamp would forget; hold the part from "
        f"before that at all places together: clamp(part, [{', '.join([repr(first), *rest])}])",
    )


@explained
def in_frame(reduced: ReducedPart, frame: Frame) -> ReducedPart:
    """Return the part with the modes of another reference condition.

    The motion of the frame in each mode is subtracted, ``phi'_j = phi_j - t_j - theta_j x u0``,
    with t its translation at the origin and theta its rotation. The modes are then orthonormalised
    with their new mass, ``K V = M' V diag(omega^2)``. The possible deformations and their stress
    remain the same; only the motion of the frame relative to the body changes. Stiffening is
    transformed to second order with the finite rotation ``exp(theta~)`` of the frame.

    Parameters
    ----------
    reduced : ReducedPart
        Result of `reduce`.
    frame : MeanFrame, NodeFrame or ChordFrame
        The reference condition.

    Returns
    -------
    ReducedPart
        The same number of modes, sorted by their frequencies with the frame at rest.

    Raises
    ------
    InputError
        If there is no such node, it has no rotations, or the part has residual stress, which is
        defined for mean axes only.

    Examples
    --------
    Relative to the chord between its ends, a beam has the frequencies of a simply supported one;
    slender beam theory gives 23.454 Hz:

    >>> import jousto as jo
    >>> from jousto.reduction import ChordFrame, in_frame
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, steel)
    >>> rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))
    >>> in_frame(rod, ChordFrame("start", "end")).frequencies[0].round(2)
    np.float64(23.45)
    """
    return seen_from(reduced, *followed(frame, reduced), frame)


def seen_from(reduced: ReducedPart, t: Array, turn: Array, frame: Frame) -> ReducedPart:
    """Return the part relative to a frame with given motions in its modes.

    Parameters
    ----------
    reduced : ReducedPart
    t, turn : (3, n) array
        Translation at the origin, and rotation, of the frame in each mode, part frame.
    frame : Frame Reference condition, for the provenance.
    """
    where = f"reduced part '{reduced.name}'"
    if reduced.stress is not None and reduced.stress.residual is not None:
        message = (
            "its residual stress is that of mean axes: reduce with residual_stress=False, or "
            "use MeanFrame()"
        )
        raise InputError(Problem(where, message))
    # theta_j x as matrices (n, 3, 3)
    cross = np.einsum("abc,bj->jac", EPS, turn)
    I = reduced.invariants
    held = _shifted(I, -t, cross)
    # motions without mass keep the modal mass 1
    mass = held.I6 + np.eye(reduced.n) - I.I6
    stiffness, V = la.eigh(np.diag(reduced.stiffness), 0.5 * (mass + mass.T))
    modes = reduced.modes - t - np.einsum("jab,kb->kaj", cross, reduced.nodes)
    rotations = reduced.rotations
    stiffening = reduced.stiffening
    if stiffening is not None:
        stiffening = turned_stiffening(reduced, Turn(t, turn, V))
    return replace(
        reduced,
        modes=modes @ V,
        rotations=None if rotations is None else (rotations - turn) @ V,
        frequencies=np.sqrt(stiffness) / (2.0 * np.pi),
        invariants=_combined(held, V),
        stress=None if reduced.stress is None else reduced.stress.combined(V),
        stiffening=stiffening,
        provenance={
            **{key: value for key, value in reduced.provenance.items() if key != CLAMPED},
            "frame": repr(frame),
        },
    )


def by_mean_axes(reduced: ReducedPart) -> ReducedPart:
    """Return the part relative to its mean axes, the default of `reduce`."""
    return in_frame(reduced, MeanFrame()) if "frame" in reduced.provenance else reduced


@singledispatch
def followed(frame: object, reduced: ReducedPart) -> tuple[Array, Array]:
    """Return the motion of a frame in each mode: translation at the origin and rotation (3, n)."""
    message = f"frame is {frame!r}, must be MeanFrame(), NodeFrame(...) or ChordFrame(...)"
    raise InputError(Problem(f"reduced part '{reduced.name}'", message))


@followed.register
def _(frame: NodeFrame, reduced: ReducedPart) -> tuple[Array, Array]:
    k = reduced.node(frame.node)
    turn = reduced.rotation(k)
    if turn is None:
        message = f"node '{frame.node}' has no rotation, which the frame needs; use an interface"
        raise InputError(Problem(f"reduced part '{reduced.name}'", message))
    return reduced.modes[k] - np.cross(turn, reduced.nodes[k], axisa=0, axisc=0), turn


@followed.register
def _(frame: ChordFrame, reduced: ReducedPart) -> tuple[Array, Array]:
    where = f"reduced part '{reduced.name}'"
    a, b = reduced.node(frame.first), reduced.node(frame.second)
    chord = reduced.nodes[b] - reduced.nodes[a]
    length = float(np.linalg.norm(chord))
    if length <= SHORT * float(np.ptp(reduced.nodes, axis=0).max()):
        message = f"'{frame.first}' and '{frame.second}' coincide, so that there is no chord"
        raise InputError(Problem(where, message))
    turns = [turn for turn in (reduced.rotation(a), reduced.rotation(b)) if turn is not None]
    if not turns:
        message = (
            f"neither '{frame.first}' nor '{frame.second}' has rotations, so the rotation about "
            f"the chord is undetermined; use an interface for one of them"
        )
        raise InputError(Problem(where, message))
    e = chord / length
    across = np.cross(e, reduced.modes[b] - reduced.modes[a], axisb=0, axisc=0) / length
    turn = across + np.outer(e, e @ turns[0])
    return reduced.modes[a] - np.cross(turn, reduced.nodes[a], axisa=0, axisc=0), turn


@followed.register
def _(frame: MeanFrame, reduced: ReducedPart) -> tuple[Array, Array]:
    I = reduced.invariants
    c = I.rigid_motion(np.concatenate([I.I3, I.I4]))
    return c[:3], c[3:]


def _shifted(I: Invariants, d: Array, cross: Array) -> Invariants:
    """Return the invariants of the modes ``phi_j + d_j - theta_j x u0``."""
    first, second = I.first_moment, I.second_moment
    N_cross = np.einsum("jba,kcb->jkac", I.N0, cross)  # N0_j^T theta_k~^T
    E = (
        I.E
        + np.einsum("aj,bk->jkab", I.I3, d)
        - N_cross
        + np.einsum("aj,bk->jkab", d, I.I3)
        + I.mass * np.einsum("aj,bk->jkab", d, d)
        - np.einsum("aj,c,kbc->jkab", d, first, cross)
        - np.einsum("jac,kcb->jkab", cross, I.N0)
        - np.einsum("jac,c,bk->jkab", cross, first, d)
        + np.einsum("jac,cd,kbd->jkab", cross, second, cross)
    )
    return Invariants(
        mass=I.mass,
        first_moment=first,
        second_moment=second,
        I3=I.I3 + I.mass * d - np.einsum("jab,b->aj", cross, first),
        N0=I.N0 + np.einsum("a,bj->jab", first, d) - np.einsum("ac,jbc->jab", second, cross),
        E=0.5 * (E + E.transpose(1, 0, 3, 2)),
    )


def _combined(I: Invariants, V: Array) -> Invariants:
    """Return the invariants of the modes ``sum_j phi_j V_jk``."""
    E = np.einsum("jkab,jl,km->lmab", I.E, V, V, optimize=True)
    return Invariants(
        mass=I.mass,
        first_moment=I.first_moment,
        second_moment=I.second_moment,
        I3=I.I3 @ V,
        N0=np.einsum("jab,jl->lab", I.N0, V),
        E=0.5 * (E + E.transpose(1, 0, 3, 2)),
    )
