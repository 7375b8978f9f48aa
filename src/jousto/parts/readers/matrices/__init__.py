"""Mass and stiffness matrices of other programs."""

from jousto.parts.readers.matrices.matrices import Matrices, nodal
from jousto.parts.readers.matrices.read import FORMATS, read_matrices
from jousto.parts.readers.matrices.units import SYSTEMS, Units

__all__ = ["FORMATS", "SYSTEMS", "Matrices", "Units", "nodal", "read_matrices"]
