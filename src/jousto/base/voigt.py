"""Voigt order of the six components of a symmetric tensor, used throughout jousto."""

from __future__ import annotations

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Row and column of each component in the tensor."""

STRESS_COMPONENTS = ("s11", "s22", "s33", "s12", "s23", "s13")
STRAIN_COMPONENTS = ("e11", "e22", "e33", "g12", "g23", "g13")
"""Names of the components; g are engineering shear strains."""
