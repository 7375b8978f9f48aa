"""clamp, in_frame: the same flexible body relative to another body frame."""

from __future__ import annotations

from dataclasses import replace
from functools import singledispatch

import numpy as np
import scipy.linalg as la

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.frames.frame import ChordFrame, Frame, MeanFrame, NodeFrame
from jousto.reduction.frames.stiffening_transform import Turn, turned_stiffening
from jousto.reduction.reduced import ReducedPart

SHORT = 1e-9
"""Smallest length of a chord / size of the part."""


@explained
def clamp(reduced: ReducedPart, node: str) -> ReducedPart:
    """Return the part clamped at a node: modes that vanish there, frequencies of the clamped part.

    This is ``in_frame(reduced, NodeFrame(node))``.

    Parameters
    ----------
    reduced : ReducedPart
        Result of `reduce`; for accurate clamped modes the node must be one of its interfaces.
    node : str
        Name of a node with rotations: an interface, a set of one node or ``"node7"``.

    Returns
    -------
    ReducedPart
        The same number of modes, sorted by their clamped frequencies.

    Raises
    ------
    InputError
        If there is no such node, or it has no rotations.

    Examples
    --------
    A steel cantilever of 20 x 10 mm; slender beam theory gives 8.3552 Hz:

    >>> import jousto as jo
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, steel)
    >>> rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))
    >>> jo.reduction.clamp(rod, "start").frequencies[0].round(2)
    np.float64(8.35)
    """
    return in_frame(reduced, NodeFrame(node))


@explained
def in_frame(reduced: ReducedPart, frame: Frame) -> ReducedPart:
    """Return the part with the modes of another reference condition.

    The motion of the frame in each mode is subtracted, ``phi'_j = phi_j - t_j - theta_j x u0``,
    with t its translation at the origin and theta its rotation. The modes are then orthonormalised
    with their new mass, ``K V = M' V diag(omega^2)``. The possible deformations and their stress do
    not change, only the motion of the frame relative to the body does. Stiffening is transformed to
    second order with the finite rotation ``exp(theta~)`` of the frame.

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
        Translation of the frame's point at the origin and rotation in each mode, part frame.
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
        provenance={**reduced.provenance, "frame": repr(frame)},
    )


def by_mean_axes(reduced: ReducedPart) -> ReducedPart:
    """Return the part relative to its mean axes, as created by `reduce` without a frame."""
    return in_frame(reduced, MeanFrame()) if "frame" in reduced.provenance else reduced


@singledispatch
def followed(frame: object, reduced: ReducedPart) -> tuple[Array, Array]:
    """Return the translation at the origin and the rotation (3, n) of a frame in each mode."""
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
