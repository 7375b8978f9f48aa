"""Flap and lag frequencies of a rotating cantilever against published values.

Uniform, inextensional, hub radius zero; frequencies and speed in units of sqrt(E I/(rho A L^4)).
Wright, Smith, Thresher and Wang, "Vibration modes of centrifugally stiffened beams", J. Appl.
Mech. 49 (1982) 197-202, solve ``w'''' - W^2 ((1 - x^2)/2 w')' = f^2 w`` by power series. Lag: the
same with ``f^2 + W^2``, since the centrifugal force also acts across (Southwell's relation).
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.reduction.frames.frame import Frame
from parts.grids import grid
from verification.hubs import on_a_hub

SECTION = jo.Rectangle(0.02, 0.01)  # in lag E I is four times that of flap
STEEL = jo.Material(E=2e11, nu=0.3, rho=7850.0)
UNIT = float(np.sqrt(STEEL.E * min(SECTION.Iy, SECTION.Iz) / (STEEL.rho * SECTION.A)))
# speed: first and second flap frequency
FLAP = {
    0.0: (3.5160, 22.0345),
    1.0: (3.6817, 22.1810),
    2.0: (4.1373, 22.6149),
    3.0: (4.7973, 23.3203),
    6.0: (7.3604, 26.8091),
    12.0: (13.1702, 37.6031),
}


def frequencies(speed: float, stiffening: bool) -> NDArray[np.float64]:
    """Frequencies of a beam of 1 m fixed to a heavy hub that turns about z, over UNIT."""
    return turning(blade(stiffening), speed)


@cache
def blade(stiffening: bool) -> jo.ReducedPart:
    part = jo.Part.beam(1.0, SECTION, 8, STEEL, theory=jo.parts.EulerBernoulli())
    return jo.reduce(part, jo.CraigBampton(("start",), modes=12), stiffening=stiffening)


@cache
def solid_blade() -> jo.ReducedPart:
    """The same of solids, without lateral contraction, its root tied rigidly to a node."""
    mesh = grid("hexahedron20", (30, 1, 1), (1.0, 0.02, 0.01), bend=lambda x: x - [0, 0.01, 0.005])
    part = jo.Part.solid(
        mesh,
        jo.Material(E=STEEL.E, nu=0.0, rho=STEEL.rho),
        interfaces=[jo.Interface("start", np.flatnonzero(mesh.nodes[:, 0] < 1e-9))],
    )
    return jo.reduce(part, jo.CraigBampton(("start",), modes=12), stiffening=True)


def turning(rod: jo.ReducedPart, speed: float) -> NDArray[np.float64]:
    """Frequencies of a body fixed by its start to a heavy hub that turns about z, over UNIT."""
    rates = on_a_hub(rod, "start", speed * UNIT)
    return rates[rates > 0.1 * UNIT] / UNIT


def nearest(found: NDArray[np.float64], wanted: float) -> float:
    return float(found[np.argmin(np.abs(found - wanted))])


@pytest.mark.parametrize("speed", FLAP)
def test_flap(speed: float) -> None:
    found = frequencies(speed, True)
    for wanted in FLAP[speed]:
        assert nearest(found, wanted) == pytest.approx(wanted, rel=5e-4)


@pytest.mark.parametrize("speed", [0.0, 3.0, 12.0])
@pytest.mark.parametrize(
    "frame", [jo.reduction.NodeFrame("start"), jo.reduction.ChordFrame("start", "end")]
)
@pytest.mark.parametrize("solid", [False, True], ids=["beam", "solid"])
def test_seen_from_the_hub(speed: float, frame: Frame, solid: bool) -> None:
    """A blade whose frame sits on the hub, or goes through both of its ends, stiffens as well."""
    if solid and isinstance(frame, jo.reduction.ChordFrame):
        pytest.skip("the tip of the solid blade has no node")
    mean = solid_blade() if solid else blade(True)
    found = turning(jo.reduction.in_frame(mean, frame), speed)
    for wanted in FLAP[speed]:
        assert nearest(found, wanted) == pytest.approx(wanted, rel=8e-4 if solid else 5e-4)
    lag = float(np.sqrt((2.0 * FLAP[speed / 2.0][0]) ** 2 - speed**2)) if speed != 3.0 else None
    if lag is not None:
        assert nearest(found, lag) == pytest.approx(lag, rel=8e-4 if solid else 5e-4)


@pytest.mark.parametrize("speed", [0.0, 6.0, 12.0])
def test_a_solid_blade(speed: float) -> None:
    """Flap and lag of a blade of thirty 20-node hexahedra."""
    found = turning(solid_blade(), speed)
    for wanted in FLAP[speed]:
        assert nearest(found, wanted) == pytest.approx(wanted, rel=8e-4)
    lag = float(np.sqrt((2.0 * FLAP[speed / 2.0][0]) ** 2 - speed**2))
    assert nearest(found, lag) == pytest.approx(lag, rel=8e-4)


@pytest.mark.parametrize("speed", [2.0, 6.0, 12.0])
def test_lag(speed: float) -> None:
    """With twice the unit, lag at W is sqrt((2 flap(W/2))^2 - W^2)."""
    wanted = float(np.sqrt((2.0 * FLAP[speed / 2.0][0]) ** 2 - speed**2))
    assert nearest(frequencies(speed, True), wanted) == pytest.approx(wanted, rel=5e-4)


def test_without_stiffening_it_softens() -> None:
    """The known error of the linear body: at W = 12 flap is 15 per cent low."""
    found = frequencies(12.0, False)
    assert np.abs(found / FLAP[12.0][0] - 1.0).min() > 0.1
    assert np.abs(found / FLAP[12.0][1] - 1.0).min() > 0.05
