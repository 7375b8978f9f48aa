"""What the quantities of a model come to, for readings that are zero but for rounding."""

from __future__ import annotations

from jousto.base.rounding import Scales
from jousto.model.model import Model


def scales_of(model: Model) -> Scales:
    """Return mass, size and elastic stress of a model.

    The elastic stress of a modal body is ``m omega^2 / size`` with its highest frequency, that of a
    rod up to a factor of order one; of exact beams it is Young's modulus.
    """
    mass = sum(float(body.mass[0].real) for body in model.bodies)
    stress = [
        float(body.mass[0].real) * float(body.K.real.max()) / model.size
        for body in model.bodies
        if body.n
    ]
    sections = (section for beam in model.beam_shapes for section in beam.sections)
    stress += [float(s.elasticity[0]) for s in sections if s.elasticity is not None]
    return Scales(mass, model.size, max(stress, default=0.0))
