"""Frequencies of slender beams against the closed form of Euler and Bernoulli: order of the mass.

Roots of ``cos x cosh x = -1`` (clamped and free) and ``= 1`` (free and free), Blevins,
*Formulas for Natural Frequency and Mode Shape*, 1979, table 8-1.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo

LENGTH, SIDE, RHO, E = 1.0, 1e-3, 7850.0, 210e9
ROOTS = {"clamped": 1.8751040687119611, "free": 4.730040744862704}


def strip(elements: int, mass: str, offset: tuple[float, float] = (0.0, 0.0)) -> jo.BeamBody:
    return jo.BeamBody(
        "strip",
        [(0, 0, 0), (LENGTH, 0, 0)],
        jo.Rectangle(SIDE, SIDE),
        jo.Material(E=E, nu=0.3, rho=RHO),
        elements=elements,
        mass=mass,
        bending=True,
        offset=offset,
    )


def frequency_error(elements: int, mass: str, support: str) -> float:
    beam = strip(elements, mass)
    items: list[object] = [beam]
    if support == "clamped":
        items.append(jo.Fixed("wall", jo.ground["origin"], beam["start"]))
    found = jo.modes(jo.compile(jo.Mechanism(*items))).frequencies
    lowest = found[found > 0.1][0]
    exact = ROOTS[support] ** 2 * np.sqrt(E * SIDE**2 / 12 / RHO) / LENGTH**2 / (2 * np.pi)
    return float(lowest / exact - 1)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize(("support", "at_most"), [("clamped", 2e-4), ("free", 4e-3)])
def test_end_correction_makes_frequencies_third_order(support: str, at_most: float) -> None:
    coarse, fine = (frequency_error(n, "corrected", support) for n in (8, 16))
    assert abs(coarse) < at_most
    assert 2.8 < np.log2(coarse / fine) < 3.4
    plain = frequency_error(8, "lumped", support)
    assert abs(plain) > 10 * abs(coarse)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("offset", [(0.0, 0.0), (0.1, -0.05)])
def test_corrected_mass_has_the_inertia_of_the_rod(offset: tuple[float, float]) -> None:
    n = 5
    beam = strip(n, "corrected", offset)
    m = RHO * SIDE**2 * LENGTH
    bodies = beam.bodies
    assert sum(b.mass for b in bodies) == pytest.approx(m, rel=1e-14)
    center = sum(b.mass * (b.position + b.center) for b in bodies) / m
    axis = np.array([0.5 * LENGTH, *offset])
    assert center == pytest.approx(axis, abs=1e-14)
    J = sum(b.inertia + b.mass * steiner(b.position + b.center - center) for b in bodies)
    # slender rod, the section's own inertia, and what keeps the mass matrix positive: m h^2/60 at
    # either end
    small, section = m / n * (LENGTH / n) ** 2 / 30, m * SIDE**2 / 12
    across = m * LENGTH**2 / 12 + section + small
    assert pytest.approx(np.diag([2 * section, across, across]), rel=1e-12, abs=1e-16) == J
    assert min(np.linalg.eigvalsh(b.inertia).min() for b in bodies) > 0


def steiner(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(x @ x * np.eye(3) - np.outer(x, x))
