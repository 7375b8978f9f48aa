"""Section stress of a moving body against closed forms and against the engine's sensor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.recovery.fields.criteria import von_mises

L, B, H = 1.0, 0.03, 0.045  # m
F = 8.0  # N; small, for the tension acts on the deflected beam with an error of second order


def stress(run: jo.Solution, reduced: jo.ReducedPart, body: str, sites: Any = None) -> Any:
    """Return the history of the stress at all sites (nt, ns, 6)."""
    return jo.stress_field(run, body, reduced=reduced, sites=sites).history(slice(None))


def beam(modes: int = 4) -> jo.ReducedPart:
    part = jo.Part.beam(L, jo.Rectangle(B, H), 4, jo.Material(210e9, 0.3, 7850.0))
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes))


@pytest.fixture(scope="module")
def reduced() -> jo.ReducedPart:
    return beam()


@pytest.fixture(scope="module")
def run(reduced: jo.ReducedPart) -> jo.Solution:
    """A cantilever under a tip force with components along all axes, put on slowly."""
    body = jo.FlexibleBody("beam", reduced, damping=0.2)
    s = np.linspace(0.0, 1.0, 201)
    ramp = jo.Table(s, s**3 * (10 - 15 * s + 6 * s**2))
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Fixed("wall", jo.ground["origin"], body["start"]),
            jo.Force("load", body["end"], (5 * F, F, -F), signal=ramp),
            jo.Torque("twist", body["end"], (0.1 * F, 0.0, 0.0), signal=ramp),
            jo.StressSensor("all", body),
            jo.StressSensor("some", body, ("e1.a.top", "e3.b.left")),
        )
    )
    return jo.simulate(model, 1.2, solver=jo.ROS2(2e-4), output_step=0.01)


def test_history_is_that_of_the_sensor(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    s = stress(run, reduced, "beam")
    assert reduced.stress is not None
    assert s.shape == (121, len(reduced.stress.labels), 6)
    scale = np.abs(s).max()
    np.testing.assert_allclose(s.reshape(121, -1), run["all"], atol=1e-12 * scale)
    some = stress(run, reduced, "beam", ("e1.a.top", "e3.b.left"))
    np.testing.assert_allclose(some.reshape(121, -1), run["some"], atol=1e-12 * scale)


@pytest.mark.parametrize("element", [1, 2, 3, 4])
def test_bending_and_tension(run: jo.Solution, reduced: jo.ReducedPart, element: int) -> None:
    # s11 = N / A + M / W at the ends of each element
    lever = L - 0.25 * (element - 1)
    Wy, Wz, N = B * H**2 / 6, H * B**2 / 6, 5 * F / (B * H)
    sites = [f"e{element}.a.{point}" for point in ("top", "bottom", "left", "right")]
    s11 = stress(run, reduced, "beam", sites)[-1, :, 0]
    # the downward force pulls at the top (+z), the force along +y at the right (-y)
    expected = N + F * lever * np.array([1 / Wy, -1 / Wy, -1 / Wz, 1 / Wz])
    np.testing.assert_allclose(s11, expected, rtol=1e-3)


def test_torsion_of_a_rectangle(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    # Timoshenko and Goodier, art. 109: T / (k2 a b^2) on the long side, k2 = 0.231 for 3 : 2
    sides = stress(run, reduced, "beam", ["e2.a.left", "e2.a.right"])[-1, :, 5]
    twist = 0.5 * (sides[0] - sides[1])
    assert abs(twist) == pytest.approx(0.1 * F / (0.231 * H * B**2), rel=2e-3)


def test_von_mises_of_known_states(rng: np.random.Generator) -> None:
    assert von_mises([0, 0, 0, 0, 2.0, 0]) == pytest.approx(2.0 * 3**0.5)
    assert von_mises([7.0, 7.0, 7.0, 0, 0, 0]) == pytest.approx(0.0)
    # the same in any axes: from the second invariant of the deviator
    tensor = rng.normal(size=(3, 3))
    tensor += tensor.T
    deviator = tensor - np.trace(tensor) / 3 * np.eye(3)
    voigt = tensor[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]]
    assert von_mises(voigt) == pytest.approx(np.sqrt(1.5 * np.sum(deviator**2)))


def test_peak(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    assert reduced.stress is not None
    value = von_mises(stress(run, reduced, "beam"))
    at, site = np.unravel_index(value.argmax(), value.shape)
    whole = jo.hot_spots(jo.stress_field(run, "beam", reduced=reduced), count=1)[0]
    assert whole.value == pytest.approx(value.max(), rel=1e-14)
    assert (whole.site, whole.time) == (reduced.stress.labels[site], run.time[at])
    assert whole.site.startswith("e1.a.")
    assert np.array_equal(whole.position, reduced.stress.positions[site])


def test_refusals(run: jo.Solution, reduced: jo.ReducedPart) -> None:
    with pytest.raises(
        jo.InputError, match=r"no stress site or set 'e1.a.tob'; did you mean 'e1.a.top'"
    ):
        stress(run, reduced, "beam", ("e1.a.tob", "e1.a.top"))
    with pytest.raises(jo.InputError, match="sites is empty"):
        stress(run, reduced, "beam", ())
    with pytest.raises(jo.InputError, match="no body 'bean'; did you mean 'beam'"):
        stress(run, reduced, "bean")
    with pytest.raises(jo.InputError, match="give the part of the body"):
        stress(run, beam(modes=6), "beam")
    with pytest.raises(jo.InputError, match="mode shapes are not those of part"):
        stress(run, reduced.keep([1, 0, *range(2, reduced.n)]), "beam")
    bare = jo.ReducedPart(
        "bare",
        reduced.nodes,
        reduced.elements,
        reduced.node_sets,
        reduced.modes,
        reduced.rotations,
        reduced.frequencies,
        reduced.invariants,
    )
    with pytest.raises(jo.InputError, match="has no stress data"):
        stress(run, bare, "beam")
