"""Stress at nodes of coarse meshes against NAFEMS: thick plate LE10, membrane LE1."""

from __future__ import annotations

import numpy as np
import pytest

from verification import nafems


@pytest.mark.parametrize(
    ("kind", "counts", "limit"),
    [
        # the strain of the face halves the error of what is continued from inside: 6.6 % of the
        # first mesh became 3.4 %
        ("hexahedron20", (6, 6, 2), 0.035),
        ("hexahedron20", (6, 4, 2), 0.025),
        ("hexahedron20", (12, 8, 4), 0.015),
        ("wedge15", (6, 6, 2), 0.02),
        ("tetra10", (6, 6, 2), 0.1),
        ("tetra10", (12, 8, 4), 0.055),
    ],
)
def test_thick_plate(kind: str, counts: tuple[int, int, int], limit: float) -> None:
    """LE10: s22 of -5.38 MPa at D."""
    found = nafems.le10(kind, counts).nodes
    assert found == pytest.approx(np.full(len(found), nafems.LE10), rel=limit)


@pytest.mark.parametrize("kind", ["hexahedron20", "wedge15", "hexahedron"])
@pytest.mark.parametrize("counts", [(6, 4, 2), (6, 6, 2)])
def test_thick_plate_with_known_pressure(kind: str, counts: tuple[int, int, int]) -> None:
    """LE10 from the strain of the loaded face: a pressure p across it adds ``-nu/(1 - nu) p``."""
    skin = nafems.le10(kind, counts).skin("top")
    assert skin - 0.3 / 0.7 * 1e6 == pytest.approx(nafems.LE10, rel=0.06)


@pytest.mark.parametrize(
    ("kind", "limit"), [("hexahedron20", 0.045), ("tetra10", 0.025), ("wedge15", 0.095)]
)
def test_membrane(kind: str, limit: float) -> None:
    """LE1: s22 of 92.7 MPa at D, six elements around the hole."""
    found = nafems.le1(kind).nodes
    assert found == pytest.approx(np.full(len(found), nafems.LE1), rel=limit)
