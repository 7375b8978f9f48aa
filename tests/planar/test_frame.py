"""PlanarFrame says everything that is wrong with it at once."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jousto as jo
from jousto.planar.dynamics import simulate_planar
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import (
    FunctionLink,
    LinearLink,
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarSupport,
    RigidLink,
)
from jousto.planar.methods import PlanarGeneralizedAlpha, PlanarNewmark
from jousto.planar.results import planar_spinning
from jousto.planar.section import PlanarSection
from planar.frames import ROD, chain


def test_all_problems_at_once() -> None:
    with pytest.raises(jo.InputError) as error:
        PlanarFrame(
            {"left": (0, 0), "right": (1, math.nan), "top": (0, 1)},
            [PlanarBeam("left", "rihgt", ROD), PlanarBeam("left", "left", ROD, name="short")],
            supports=[PlanarSupport("bottom")],
            loads=["weight"],  # type: ignore[list-item]
            gravity=(0.0, math.inf),
        )
    text = str(error.value)
    assert "node 'right': position[1] is nan, must be finite" in text
    assert "no node 'rihgt'; did you mean 'right'?" in text
    assert "supports[0]: no node 'bottom'" in text
    assert "loads has 'weight', must be PlanarLoad" in text
    assert "gravity[1] is inf" in text


def test_values_of_items() -> None:
    with pytest.raises(jo.InputError) as error:
        PlanarFrame(
            [(0, 0), (1, 0)],
            [PlanarBeam(0, 1, ROD), PlanarBeam(1, 1, ROD, name="short")],
            loads=[PlanarLoad(1, force=(math.nan, 0.0), signal=3.0)],  # type: ignore[arg-type]
            masses=[PlanarMass(1, -2.0)],
        )
    text = str(error.value)
    assert "beam 'short': both ends are at (1, 0) m; give it a length" in text
    assert "force[0] is nan" in text
    assert "signal is 3.0, must be a function of the time in s" in text
    assert "mass is -2 kg, must be zero or a positive number" in text
    with pytest.raises(jo.InputError, match="EA is -1 N(.|\n)*GA is nan N(.|\n)*rotary is -1"):
        PlanarSection(EA=-1.0, GA=math.nan, EI=1.0, rotary=-1.0)
    with pytest.raises(jo.InputError, match="mass is -1 1/s"):
        PlanarDamping(mass=-1.0)
    with pytest.raises(jo.InputError, match="step is 0 s"):
        PlanarNewmark(0.0)
    with pytest.raises(jo.InputError, match="rho is 1.1, must be a number from 0 to 1"):
        PlanarGeneralizedAlpha(1e-3, rho=1.1)


def test_sections_in_other_units_warn() -> None:
    # EI in N mm^2
    with pytest.warns(jo.JoustoWarning, match="radius of gyration sqrt.EI/EA. is 10 m"):
        chain(2, section=PlanarSection(EA=1e7, GA=1e7, EI=1e9))


def test_links_are_checked() -> None:
    nodes = [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0)]
    beams = [PlanarBeam(0, 1, ROD)]
    with pytest.raises(jo.InputError) as error:
        PlanarFrame(
            nodes,
            beams,
            supports=[PlanarSupport(2)],
            links=[
                RigidLink(1, (2,)),
                RigidLink(2, (3,)),
                LinearLink((2,), (0,), np.zeros((3, 2))),
                FunctionLink((4,), (0,), lambda u: u[:2]),
            ],
        )
    text = str(error.value)
    assert "links[2]: node 2 is already a slave of links[0]; a node has one master" in text
    assert "links[1]: master 2 is itself a slave of links[2]" in text
    assert "T has shape (3, 2), must be (3, 3)" in text
    assert "links[3]: its function returns shape (2,), must be (3,)" in text
    assert "supports[0]: node 2 is a slave of links[2]; support its master instead" in text


def test_section_of_a_beam() -> None:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    s = PlanarSection.of(jo.Rectangle(0.02, 0.03), steel)
    box = jo.Rectangle(0.02, 0.03)
    assert (s.EA, s.EI, s.mass) == pytest.approx((2.1e11 * 6e-4, 2.1e11 * box.Iz, 7850 * 6e-4))
    assert pytest.approx(5 / 6 * steel.G * 6e-4) == s.GA
    assert PlanarSection.of(box, steel, GA=1e7).GA == 1e7
    # the limit is where a stretched bar may turn its sections: N = GA (1 + N / EA)
    assert s.limit == pytest.approx(s.GA * (1 + s.limit / s.EA))


def test_unknowns_without_mass_are_named() -> None:
    bare = PlanarSection(EA=1e5, GA=1e5, EI=10.0)
    with pytest.raises(jo.InputError, match="no mass moves with x of node 1, y of node 1, x of"):
        simulate_planar(chain(2, section=bare), 0.1, PlanarNewmark(0.01))


def test_spinning_needs_a_frame_without_links() -> None:
    frame = PlanarFrame(
        [(0, 0), (1, 0), (2, 0)], [PlanarBeam(0, 1, ROD)], links=[RigidLink(1, (2,))]
    )
    with pytest.raises(jo.InputError, match="PlanarState"):
        planar_spinning(frame, 1.0)
