"""FrameShape: beam elements of a modal body, for drawing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.complexstep import floats
from jousto.base.object_repr import described

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

ELEMENTS = ("origin", "axes", "length", "offsets", "phi")
ARRAYS = (*ELEMENTS, "rotations", "which")
"""Fields that are arrays."""


@described
@dataclass(frozen=True, eq=False)
class FrameShape:
    """Beam elements of a modal body, for position and rotation of sections between nodes.

    Attributes
    ----------
    origin, axes, length, offsets, phi : arrays (ne, 3), (ne, 3, 3), (ne,), (ne, 2, 3), (ne, 2)
        Data of the elements, see `BeamElements`.
    rotations : (nn, 3, n) array
        Rotation of the nodes in each mode, kg^-0.5/m.
    edges : tuple of (k, 2) arrays
        Outlines of the sections, m.
    which : (ne,) int array
        Index of the outline of each element.
    """

    origin: Array
    axes: Array
    length: Array
    offsets: Array
    phi: Array
    rotations: Array
    edges: tuple[Array, ...]
    which: Index


def frame_shape(reduced: ReducedPart) -> FrameShape | None:
    """Return the beam elements of a part; None without elements or outlines."""
    beams, outlines, rotations = reduced.beams, reduced.outlines, reduced.rotations
    if beams is None or outlines is None or rotations is None or not len(beams):
        return None
    if reduced.rotation_nodes is not None:
        return None
    return FrameShape(
        **{name: np.array(floats(getattr(beams, name))) for name in ELEMENTS},
        rotations=np.array(floats(rotations)),
        edges=outlines.edges,
        which=np.asarray(outlines.which, dtype=np.intp),
    )
