"""What the quantities of a model come to, for readings that are zero but for rounding."""

from __future__ import annotations

import numpy as np

from jousto.base.rounding import Scales
from jousto.model.model import Model


def scales_of(model: Model) -> Scales:
    """Return mass, size and elastic stress of a model.

    The elastic stress of a modal body is ``m omega^2 / size`` with its highest frequency, that of a
    rod up to a factor of order one; of exact beams it is Young's modulus.
    """
    # complex steps: a derivative has no scale
    mass = sum(real(body.mass[0]) for body in model.bodies)
    size = real(model.size)
    stress = [real(body.mass[0]) * real(body.K.max()) / size for body in model.bodies if body.n]
    sections = (section for beam in model.beam_shapes for section in beam.sections)
    stress += [real(s.elasticity[0]) for s in sections if s.elasticity is not None]
    return Scales(mass, size, max(stress, default=0.0))


def real(x: complex) -> float:
    """Return the real part of a number."""
    return float(np.real(x))
