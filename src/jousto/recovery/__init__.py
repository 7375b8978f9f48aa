"""RECOVER: fields over a body from the few coordinates that a run stores."""

from jousto.recovery.shape import find_body, positions, rotation_matrices
from jousto.recovery.stress import Peak, peak, stress, surface_stress, von_mises

__all__ = [
    "Peak",
    "find_body",
    "peak",
    "positions",
    "rotation_matrices",
    "stress",
    "surface_stress",
    "von_mises",
]
