"""Loads from strains: the published errors of the cantilever, round trips, refusals."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.twin.loads import equivalent_load, external, locate_load, place_loads
from measurement.twin.cantilever import Clamped, clamped

BASE = 3.0  # Hz: the window is a third of a second
NT = 64


@pytest.fixture(scope="module")
def beam() -> Clamped:
    return clamped()


def steady(beam: Clamped, F: np.ndarray, harmonic: int, ratio: float = 0.0) -> np.ndarray:
    """Complex amplitude under F cos(j w t) with the same damping ratio in all modes."""
    w = 2 * np.pi * BASE * harmonic
    f = beam.modes.T @ F
    q = f / (beam.omega**2 - w**2 + 2j * ratio * w * beam.omega)
    return np.asarray(beam.modes @ q)


def strains(beam: Clamped, F: np.ndarray, ratio: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A static tip load with 3, 6 and 9 Hz of the same size."""
    t = np.arange(NT) / (BASE * NT)
    u = np.zeros((NT, len(F)))
    for j in range(4):
        amplitude = steady(beam, F, j, ratio)
        u += (amplitude * np.exp(2j * np.pi * BASE * j * t)[:, None]).real
    return t, u @ beam.strain.T


@pytest.mark.parametrize(("modes", "error", "within"), [(3, 0.044, 0.002), (5, 0.26, 0.005)])
def test_modal_loads_of_normal_modes_alone(
    beam: Clamped, modes: int, error: float, within: float
) -> None:
    """Worst modal load 4.4 % off with three modes; 26 % with five, which the root does not show."""
    F = np.zeros(len(beam.K))
    F[-2] = 1e-3
    t, e = strains(beam, F)
    twin = jo.twin.Reconstruction(beam.strain @ beam.modes[:, :modes])
    found = jo.twin.identify_fourier(twin, t, e, beam.omega[:modes] ** 2, harmonics=3)
    true = beam.modes[:, :modes].T @ F
    series = np.vstack([found.constant, found.cosine])
    # the second digit depends on the side of a node that a gauge at it reads
    assert np.abs(series / true - 1).max() == pytest.approx(error, abs=within)
    assert np.abs(found.sine).max() < 1e-9 * np.abs(true).max()
    np.testing.assert_allclose(found.frequencies, [3.0, 6.0, 9.0])


@pytest.mark.parametrize("ratio", [0.0, 0.03])
def test_round_trip_of_any_modal_loads(
    beam: Clamped, ratio: float, rng: np.random.Generator
) -> None:
    """Loads that the basis holds come back exactly, damped or not (S33 to S36)."""
    n = 4
    shapes, w2 = beam.modes[:, :n], beam.omega[:n] ** 2
    t = np.arange(NT) / (BASE * NT)
    f0, fc, fs = rng.normal(size=n), rng.normal(size=(3, n)), rng.normal(size=(3, n))
    p = np.tile(f0 / w2, (NT, 1))
    for j in range(3):
        w = 2 * np.pi * BASE * (j + 1)
        c = (fc[j] - 1j * fs[j]) / (w2 - w**2 + 2j * ratio * w * beam.omega[:n])
        p += (c * np.exp(1j * w * t)[:, None]).real
    twin = jo.twin.Reconstruction(beam.strain @ shapes)
    e = 1e-3 * p @ shapes.T @ beam.strain.T
    found = jo.twin.identify_fourier(twin, t + 5.0, e, w2, damping=ratio, limit=9.5)
    np.testing.assert_allclose(found.constant, 1e-3 * f0, atol=1e-9)
    np.testing.assert_allclose(found.cosine, 1e-3 * fc, atol=1e-8)
    np.testing.assert_allclose(found.sine, 1e-3 * fs, atol=1e-8)
    phase = 2 * np.pi * BASE * np.outer(t, [1, 2, 3])
    np.testing.assert_allclose(
        found.at(t + 5.0), 1e-3 * (f0 + np.cos(phase) @ fc + np.sin(phase) @ fs), atol=1e-8
    )
    # equivalent nodal loads make the same modal loads
    F = equivalent_load(beam.M, shapes, found.at(t))
    np.testing.assert_allclose(F @ shapes, found.at(t), atol=1e-12)


def test_loads_at_known_places(rng: np.random.Generator) -> None:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, jo.Material(2.1e11, 0.3, 7850.0))
    rod = jo.reduce(part, jo.CraigBampton(("start", "node6", "end"), modes=2))
    loads = [jo.twin.UnknownLoad("node6", "fz"), jo.twin.UnknownLoad("end", "fy fz")]
    L = np.hstack([load.columns(rod)[0] for load in loads])
    a = rng.normal(size=(5, 3))
    found, rest = place_loads(a @ L.T, loads, rod)
    np.testing.assert_allclose(found, a, rtol=1e-9)
    assert rest < 1e-12
    assert place_loads(a @ L.T, loads[1], rod)[1] > 0.01
    # where did it act?
    one = a[:, :1] @ L[:, :1].T
    ranking = locate_load(one, rod, ("start", "node3", "node6", "end"), ("fz",))
    assert ranking[0] == ("node6", pytest.approx(0.0, abs=1e-9)) and ranking[1][1] > 0.05


def test_external_loads_of_a_turning_body() -> None:
    """A beam that spins freely: all its modal load is inertia, nothing comes from outside."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.04, 0.02), 8, jo.Material(2.1e11, 0.3, 7850.0))
    rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    t, w = np.linspace(0.0, 1.0, 11), np.tile([0.0, 0.0, 30.0], (11, 1))
    # at rest in the turning frame its centre is accelerated by 0.5 m w^2 towards the origin
    a = np.cross(w, np.cross(w, -rod.invariants.first_moment / rod.invariants.mass))
    reference = jo.twin.Reference(t, a, w, np.zeros((11, 3)))
    stretched = np.einsum("jaa->j", rod.invariants.N0) * 900.0 - 900.0 * rod.invariants.N0[:, 2, 2]
    p = np.tile(stretched / rod.stiffness, (11, 1))
    f = p * rod.stiffness
    assert np.abs(f).max() > 10.0
    assert np.abs(external(f, rod, p, t, reference)).max() < 1e-4 * np.abs(f).max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t, e: (t[[0, 1, 3, 4]], e[:4]), "evenly spaced"),
        (lambda t, e: (t, np.where(np.arange(len(e))[:, None] == 3, np.nan, e)), "gaps"),
        (lambda t, e: (t[::-1], e), "time runs backwards"),
    ],
)
def test_bad_windows(beam: Clamped, change: object, message: str) -> None:
    twin = jo.twin.Reconstruction(beam.strain @ beam.modes[:, :3])
    t, e = change(np.arange(8.0), np.zeros((8, 6)))  # type: ignore[operator]
    with pytest.raises(jo.InputError, match=message):
        jo.twin.identify_fourier(twin, t, e, beam.omega[:3] ** 2)


def test_bad_places(beam: Clamped) -> None:
    with pytest.raises(jo.InputError, match="2 modes cannot distinguish 3 loads"):
        place_loads(np.ones((4, 2)), np.ones((2, 3)))
    with pytest.raises(jo.InputError, match="stiffness is of 2 modes"):
        twin = jo.twin.Reconstruction(beam.strain @ beam.modes[:, :3])
        jo.twin.identify_fourier(twin, np.arange(8.0), np.zeros((8, 6)), beam.omega[:2] ** 2)
