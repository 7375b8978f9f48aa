"""Frequencies of exact beams: the chain's own to round-off, the theory's with order 2 or 4.

References: `beams_dynamic`. A ring in its plane without shear, stretch and rotary inertia has
``w^2 = EI/(m R^4) n^2 (n^2 - 1)^2/(n^2 + 1)`` (Love, Mathematical Theory of Elasticity, section
293; Timoshenko and Young, Vibration Problems in Engineering, section 5.19).
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.beams_dynamic import Line, frequencies, ring, rods, whirls

pytestmark = [
    pytest.mark.filterwarnings("ignore:.*has no joint to another body"),
    pytest.mark.filterwarnings("ignore:.*nothing will move"),
]

# a tube with the polar inertia unlike twice the other, to tell them apart
LINE = Line(EA=4.2e8, GA=9e7, GJ=2.9e5, EI=3.6e5, mass=15.7, polar=0.021, rotary=0.0135)
STIFF = Line(EA=1e9, GA=1e9, GJ=1e3, EI=1e3, mass=10.0, polar=2e-6, rotary=1e-6)
with pytest.warns(jo.JoustoWarning, match="in a flat section it is their sum"):
    SECTION = jo.mechanism.BeamSection(LINE.stiffness, LINE.mass, LINE.inertia)
SLENDER = jo.mechanism.BeamSection(STIFF.stiffness, STIFF.mass, STIFF.inertia)
L = 3.0
X, O = (1, 0, 0), jo.ground["origin"]
MASSES = {"lumped": 0.0, "half": 0.5, "consistent": 1.0}


def beam(elements, section=SECTION, **options):
    return jo.BeamBody("beam", [(0, 0, 0), (L, 0, 0)], section, elements=elements, **options)


def found(model, count=None, state=None, damped=False):
    """Angular frequencies above rigid motions, rad/s."""
    w = 2 * np.pi * jo.modes(model, state, damped=damped).frequencies
    return w[w > 1e-6 * w.max()][:count]


def shaft(elements, spin=0.0, **options):
    """On two bearings that leave the ends free to turn, one of them free to slide."""
    b = beam(elements, angular_velocity=(spin, 0, 0), **options)
    left = jo.Spherical("left", O, b["start"])
    right = jo.PointOnLine("right", jo.ground.at((L, 0, 0)), b["end"], axis=X)
    return jo.compile(jo.Mechanism(b, left, right))


@pytest.mark.parametrize("bending", [False, True], ids=["plain", "bending"])
@pytest.mark.parametrize("mass", MASSES)
def test_a_chain_on_two_supports_has_the_frequencies_of_its_dispersion(mass, bending):
    n, share = 8, MASSES[mass]
    w = found(shaft(n, mass=share, bending=bending))
    expected = []
    for wave in range(1, n):
        chain = whirls(LINE, L, wave, elements=n, share=share, bending=bending)
        expected += 2 * [*chain[chain > 0]]  # both planes
    for x in expected:
        assert np.abs(w / x - 1).min() < 1e-8, (x, w)


@pytest.mark.parametrize("mass", MASSES)
def test_stretching_and_twisting_to_round_off(mass):
    n, share = 10, MASSES[mass]
    b = beam(n, mass=share)
    w = found(jo.compile(jo.Mechanism(b, jo.Fixed("wall", O, b["start"]))))
    for family in rods(LINE, L, 3, elements=n, share=share):
        for x in family:
            assert np.abs(w / x - 1).min() < 1e-8, (x, w)


def errors(ends, elements, count, **options):
    """Relative errors (len(elements), count) of the bending frequencies in both planes."""
    exact = frequencies(LINE, L, ends, count)
    out = []
    for n in elements:
        b = beam(n, **options)
        joints = []
        if "clamped" in ends:
            joints.append(jo.Fixed("wall", O, b["start"]))
        if ends[1] == "clamped":
            # the far wall lets the end slide along x
            joints.append(jo.Prismatic("guide", jo.ground.at((L, 0, 0)), b["end"], axis=X))
        w = found(jo.compile(jo.Mechanism(b, *joints)))
        out.append([np.abs(w / x - 1).min() for x in exact])
    return np.array(out)


@pytest.mark.parametrize("bending", [False, True], ids=["plain", "bending"])
@pytest.mark.parametrize("ends", [("clamped", "free"), ("free", "free")], ids="-".join)
def test_bending_frequencies_converge_with_order_2(ends, bending):
    for mass in MASSES:
        e = errors(ends, (10, 20), 2, mass=MASSES[mass], bending=bending)
        assert (np.log2(e[0] / e[1]) > 1.8).all(), (mass, e)
        assert e[1].max() < 0.015


def test_what_the_shares_and_the_residual_flexibility_gain():
    def third(**options):
        return errors(("clamped", "free"), (12,), 3, **options)[0, 2]

    # plain elements bend too stiff by k^2 h^2/12, which a consistent mass doubles and more; the
    # softer ones with half of it leave an eighth
    consistent, half = third(mass="consistent"), third(mass=0.5)
    soft = third(mass=0.5, bending=True)
    assert half < 0.6 * consistent, (half, consistent)
    assert soft < 0.2 * half, (soft, half)


def test_between_supports_soft_slender_elements_with_lumped_mass_are_of_order_4():
    # what shear and rotary inertia do beside bending is of order 2
    e = []
    for n in (6, 12):
        w = found(shaft(n, section=SLENDER, bending=True, mass="lumped"))
        exact = [whirls(STIFF, L, wave)[2] for wave in (1, 2)]
        e.append([np.abs(w / x - 1).min() for x in exact])
    e = np.array(e)
    assert (np.log2(e[0] / e[1]) > 3.7).all(), e
    assert e[1, 0] < 1e-4


@pytest.mark.parametrize("spin", [0.0, 400.0, -900.0])
def test_a_spinning_shaft_whirls_as_its_dispersion_says(spin):
    # body axes turn with the shaft: a whirl w of the world is seen as w - spin
    n = 6
    model = shaft(n, spin, mass=0.5)
    values = jo.modes(model, damped=True).eigenvalues
    assert np.abs(values.real).max() < 1e-6 * np.abs(values).max()
    seen = np.abs(values.imag)
    for wave in (1, 2, 3):
        for w in whirls(LINE, L, wave, spin, elements=n, share=0.5):
            distance = min(np.abs(seen / abs(w - spin) - 1).min(), np.abs(seen / abs(w) - 1).min())
            assert distance < 1e-7, (wave, w)


def hoop(elements, section, **options):
    """A free ring of radius 1: its end is welded to its start."""
    a = np.linspace(0, 2 * np.pi, elements + 1)
    points = np.stack([np.cos(a), np.sin(a), 0 * a], axis=-1)
    up = np.tile([0.0, 0.0, 1.0], (elements + 1, 1))
    b = jo.BeamBody("ring", points, section, up=up, **options)
    return jo.compile(jo.Mechanism(b, jo.Fixed("weld", b["start"], b["end"])))


def in_plane(model):
    """Angular frequencies of the modes without motion along z, rad/s, without rigid motions."""
    m = jo.modes(model)
    z = np.abs(np.concatenate([*m.shapes.values()], axis=1)[..., 2]).max(axis=1)
    w = 2 * np.pi * m.frequencies
    return w[(z < 1e-3) & (w > 1e-6 * w.max())]


@pytest.mark.parametrize(("bending", "mass", "order"), [(False, 0.5, 2), (True, 0.0, 4)])
def test_rings_converge_to_the_exact_ring(bending, mass, order):
    line, section = (STIFF, SLENDER) if bending else (LINE, SECTION)
    exact = [ring(line, 1.0, n)[0] for n in (2, 3)]
    e = []
    for elements in (16, 32):
        w = in_plane(hoop(elements, section, mass=mass, bending=bending))
        e.append([np.abs(w / x - 1).min() for x in exact])
    e = np.array(e)
    assert ((np.log2(e[0] / e[1]) > order - 0.3) | (e[1] < 2e-5)).all(), e
    assert e[1].max() < (0.04 if order == 2 else 1e-3)


def test_a_slender_ring_has_the_classical_frequencies():
    w = in_plane(hoop(32, SLENDER, bending=True))
    for n in (2, 3):
        love = np.sqrt(STIFF.EI / STIFF.mass * n**2 * (n**2 - 1) ** 2 / (n**2 + 1))
        assert ring(STIFF, 1.0, n)[0] == pytest.approx(love, rel=1e-4)
        assert np.abs(w / love - 1).min() < 1e-3


def test_arches_converge_to_the_exact_arch_with_order_2():
    radius, angle = 2.0, 1.5
    exact = frequencies(LINE, radius * angle, ("clamped", "clamped"), 2, radius)
    e = []
    for elements in (10, 20):
        a = np.linspace(0, angle, elements + 1)
        points = radius * np.stack([np.cos(a), np.sin(a), 0 * a], axis=-1)
        up = np.tile([0.0, 0.0, 1.0], (elements + 1, 1))
        b = jo.BeamBody("arch", points, SECTION, up=up, mass=0.5)
        held = [
            jo.Fixed("left", jo.ground.at(points[0]), b["start"]),
            jo.Fixed("right", jo.ground.at(points[-1]), b["end"]),
        ]
        w = found(jo.compile(jo.Mechanism(b, *held)))
        e.append([np.abs(w / x - 1).min() for x in exact])
    e = np.array(e)
    assert (np.log2(e[0] / e[1]) > 1.8).all(), e
