"""Reduced parts for the tests of mechanisms."""

from __future__ import annotations

import pytest

from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle


@pytest.fixture(scope="session")
def rod() -> ReducedPart:
    """Steel rod along x, 2 m, with stress, interfaces at both ends."""
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    part = Part.beam(2.0, Rectangle(0.1, 0.05), 4, steel)
    return reduce(part, CraigBampton(interfaces=("start", "end"), modes=2))


@pytest.fixture(scope="session")
def solid() -> ReducedPart:
    """The same rod known by its translations only: nodes do not rotate, no stress."""
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    part = Part.beam(2.0, Rectangle(0.1, 0.05), 4, steel)
    reduced = reduce(part, CraigBampton(interfaces=("start", "end"), modes=2))
    return ReducedPart(
        name="solid",
        nodes=reduced.nodes,
        elements=reduced.elements,
        node_sets=reduced.node_sets,
        modes=reduced.modes,
        rotations=None,
        frequencies=reduced.frequencies,
        invariants=reduced.invariants,
    )
