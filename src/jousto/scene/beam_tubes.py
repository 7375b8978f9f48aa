"""Exact beams of a scene: rings along the axis, resultants as additional row columns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.rotations import euler_parameters
from jousto.model.beam_record import BeamShape
from jousto.recovery.beams.forces import state_forces
from jousto.recovery.beams.strains import Elements, elements
from jousto.scene.scene import Body, Rings
from jousto.scene.sections import beam_outlines, outline_rows, tube

RINGS = 48  # smallest number of rings along a beam
MOST_RINGS = 400
LEAST = 0.004  # smallest section thickness in a picture, relative to the extent of the motion


def ring_places(beam: BeamShape) -> tuple[Index, Array]:
    """Return the element index (nring,) of each ring along a beam, and its place in it (0 .. 1)."""
    sub, stride = max(1, -(-RINGS // beam.n)), max(1, beam.n // MOST_RINGS)
    first = np.arange(0, beam.n, stride)
    element = np.append(np.repeat(first, sub), beam.n - 1).astype(np.intp)
    share = np.append(np.tile(np.arange(sub) / sub, len(first)), 1.0)
    return element, share


def beam_body(beam: BeamShape, places: Index, forces: int) -> Body:
    """Return the scene body of a beam.

    Parameters
    ----------
    beam : BeamShape
    places : (n + 1,) int array
        Columns of ``[R e]`` of its nodes.
    forces : int
        First column of its resultants, -1 if its stress is not known.
    """
    at = elements(beam)
    element, share = ring_places(beam)
    edges = beam_outlines(beam)
    k = edges.shape[1]
    which = beam.which[element]
    corner = (which[:, None] * k + np.arange(k)).ravel()
    rows = np.zeros((0, 6, 6))
    if forces >= 0:
        rows = np.concatenate(
            [outline_rows(x, edge) for x, edge in zip(beam.sections, edges, strict=True)]
        )
    vertex_ring = np.repeat(np.arange(len(element)), k)
    yz = edges[which].reshape(-1, 2)
    own = np.concatenate(
        [np.stack([at.ua, at.ub], 1), _turns(np.stack([at.Ba, at.Bb], axis=1))], axis=2
    )
    # undeformed vertices in the frame of the beam
    a, b = 1.0 - share[:, None], share[:, None]
    frames = beam.frames
    ends = [
        beam.nodes[:-1] + np.einsum("nij,nj->ni", frames[:-1], at.ua),
        beam.nodes[1:] + np.einsum("nij,nj->ni", frames[1:], at.ub),
    ]
    axes = (frames[:-1] @ at.Ba)[element][:, :, 1:]
    centre = a * ends[0][element] + b * ends[1][element]
    positions = centre[vertex_ring] + np.einsum("vij,vj->vi", axes[vertex_ring], yz)
    known = None
    if forces >= 0 and np.isnan(rows).any():
        known = np.logical_not(np.isnan(rows).any(axis=(1, 2)))[corner]
    near = element[vertex_ring] + np.round(share[vertex_ring]).astype(np.intp)
    return Body(
        name=beam.name,
        kind="beam",
        place=-1,
        modes=0,
        positions=positions,
        triangles=tube(len(element), k),
        known=known,
        nodes=near + 1,
        about=f"exact beam, {beam.n} elements, {beam.s[-1]:.4g} m",
        rings=Rings(
            places=np.asarray(places, dtype=np.intp),
            ends=own,
            element=element,
            share=share,
            vertex_ring=vertex_ring,
            yz=yz,
            forces=forces,
            corner=corner,
            rows=rows,
            least=LEAST,
        ),
    )


def _turns(B: Array) -> Array:
    """Return the Euler parameters (n, 2, 4) of axes (n, 2, 3, 3)."""
    return np.array([[euler_parameters(one) for one in both] for both in B])


@dataclass(frozen=True, eq=False)
class Resultants:
    """Data for the additional columns of a row: resultants of one beam.

    Attributes
    ----------
    at : Elements
    iq, iv : (n + 1,) int arrays
        Offsets of its nodes' states in q and v.
    first : int
        Index of the beam's first column.
    """

    at: Elements
    iq: Index
    iv: Index
    first: int

    @property
    def width(self) -> int:
        """Number of columns."""
        return 12 * len(self.at.L)

    @property
    def damped(self) -> bool:
        """Whether the resultants depend on velocities."""
        return bool(np.any(self.at.beta))

    def values(self, q: Array, v: Array | None) -> Array:
        """Return the resultants at both ends of all elements (k, 12 ne) for states (k, nq)."""
        qb = q[:, self.iq[:, None] + np.arange(7)]
        vb = None if v is None else v[:, self.iv[:, None] + np.arange(6)]
        return np.asarray(state_forces(self.at, qb, vb)[2].reshape(len(q), -1))
