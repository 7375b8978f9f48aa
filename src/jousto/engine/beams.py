"""Beams of a mechanism for the engine and for results."""

from __future__ import annotations

import numpy as np

from jousto.engine.beam_shape import BeamShape
from jousto.mechanism import BeamBody, Mechanism


def beam_shapes(mechanism: Mechanism, index: dict[int, int]) -> tuple[BeamShape, ...]:
    """Return what results keep of each beam; `index` holds the place of every body by its id."""
    return tuple(_shape(beam, index) for beam in mechanism.beams)


def _shape(beam: BeamBody, index: dict[int, int]) -> BeamShape:
    section = beam.sections[0]
    same = all(other is section for other in beam.sections)
    # points of one section belong to all elements or to none
    points = section.points if same else ()
    return BeamShape(
        name=beam.name,
        bodies=np.array([index[id(body)] for body in beam.bodies], dtype=np.int64),
        data=beam.elements,
        s=beam.s,
        labels=tuple(point.name for point in points),
        points=np.array([(p.y, p.z) for p in points], dtype=float).reshape(-1, 2),
        rows=np.array([p.rows for p in points], dtype=float).reshape(-1, 6, 6),
        outline=section.outline,
        elasticity=np.array(section.elasticity) if same and section.elasticity else None,
    )
