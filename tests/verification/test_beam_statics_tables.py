"""Beams that tip over sideways, and the Princeton beam: closed forms and published numbers."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import beam_chain as bc
from verification.beam_statics import cantilever, section, straight, tip

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def test_deep_cantilever_tips_over_sideways() -> None:
    # E I = G J = L = 1, ten thousand times stiffer in its plane: 4.0126 sqrt(E I G J)/L^2
    loads = []
    for n in (8, 16):
        beam = straight(1.0, n, section(1e6, 1e6, 1e6, 1.0, 1.0, 1e4), bending=True)
        loads.append(jo.simulation.buckling(cantilever(beam, (0.0, -1.0, 0.0)), "load", 1).loads[0])
    assert loads[1] == pytest.approx(bc.lateral(), rel=2.5e-3)
    assert loads[1] + (loads[1] - loads[0]) / 3.0 == pytest.approx(bc.lateral(), rel=2e-4)


@pytest.mark.slow
def test_bending_before_it_tips_over() -> None:
    # a beam only a hundred times stiffer in its plane is bent when it tips over, which holds it:
    # 1/sqrt((1 - EIy/EIz)(1 - GJ/EIz)), to the first order (Michell, Philosophical Magazine 48
    # (1899) 298-309); linear theory knows nothing of it
    beam = straight(1.0, 16, section(1e6, 1e6, 1e6, 1.0, 1.0, 100.0), bending=True)
    model = cantilever(beam, (0.0, -1.0, 0.0))
    found = jo.simulation.buckling(model, "load", 1, method="path", to=5.0, steps=5)
    assert found.kinds == ("bifurcation",)
    assert found.loads[0] == pytest.approx(bc.lateral() / 0.99, rel=5e-3)
    assert jo.simulation.buckling(model, "load", 1).loads[0] == pytest.approx(
        bc.lateral(), rel=3e-3
    )


def test_right_angle_frame_tips_over_sideways() -> None:
    # two legs of 240 mm, 30 x 0.6 mm, E = 71240 N/mm2, nu = 0.31, clamped, an end load in the
    # plane along the first leg: 1.088 N by Argyris and others, Computer Methods in Applied
    # Mechanics and Engineering 20 (1979) 105-124; 1.09 N by Simo and
    # Vu-Quoc (1986). G J with J = b t^3/3.
    E, n = 71240.0, 10
    G, b, t = E / 2.62, 30.0, 0.6
    sec = section(E * b * t, 5 / 6 * G * b * t, 5 / 6 * G * b * t,
                  G * b * t**3 / 3, E * b * t**3 / 12, E * b**3 * t / 12)  # fmt: skip
    s = np.linspace(0.0, 240.0, n + 1)
    along = np.stack([s, 0.0 * s, 0.0 * s], axis=1)
    down = np.stack([240.0 + 0.0 * s, -s, 0.0 * s], axis=1)[1:]
    points = np.concatenate([along, down])
    frame = jo.BeamBody("frame", points, sec, up=(0, 0, 1), corners=(n,), bending=True)
    found = jo.simulation.buckling(cantilever(frame, (1.0, 0.0, 0.0)), "load", 1)
    assert found.loads[0] == pytest.approx(1.09, abs=0.005)


# Princeton beam (Dowell and Traybar 1975, US Army AAMRDL contract reports): 0.508 m of 7075
# aluminium, tip loads at angles of 0 to 90 degrees from the stiff direction. Here the benchmark of
# Obrezkov, Mikkola and Matikainen, Nonlinear Dynamics 109 (2022): 12.3777 x 3.2024 mm,
# E = 71.7 GPa, nu = 0.31; displacements of their converged ANSYS beam in m along the stiff
# and the soft direction, as tabulated in EXUDYN's ANCFBeamTest;
# their solid is 1.5 to 2.6 % stiffer.
PRINCETON = {
    8.896: (
        (0.01071417630, 0.01061328706, 0.01011169630, 0.008837226265, 0.006604665004,
         0.003538889001, 0.0),
        (0.0, 0.04208232124, 0.07939482948, 0.108987937, 0.129887616, 0.142194370, 0.146245978),
    ),
    13.345: (
        (0.01606423724, 0.01645825752, 0.01665873206, 0.01518618440, 0.01157837500,
         0.006248967384, 0.0),
        (0.0, 0.06435812858, 0.117735994, 0.156467239, 0.181861627, 0.196097131, 0.200677707),
    ),
}  # fmt: skip


@pytest.mark.parametrize("load", PRINCETON)
def test_princeton_beam(load: float) -> None:
    aluminium = jo.Material(E=71.7e9, nu=0.31, rho=2700.0)
    sec = jo.Rectangle(12.3777e-3, 3.2024e-3)
    for degrees, stiff, soft in zip(range(0, 91, 15), *PRINCETON[load], strict=True):
        beam = straight(0.508, 8, sec, material=aluminium, bending=True)
        angle = np.radians(degrees)
        end = tip(cantilever(beam, (0.0, -load * np.cos(angle), load * np.sin(angle))), 4)
        # 0.2 mm of 200
        assert -end[1] == pytest.approx(stiff, abs=1.5e-4)
        assert end[2] == pytest.approx(soft, abs=1.5e-4)
