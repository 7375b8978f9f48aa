"""Second opinions: one body by other frames and other functions moves alike and is stressed alike.

Schwertassek, Wallrapp and Shabana, "Flexible multibody simulation and choice of shape functions",
Nonlinear Dynamics 20 (1999) 361-380: the frame of reference changes the modal coordinates and no
physical motion; functions do as far as they cannot make the deformation.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.reduction import (
    AsGiven,
    BeamFunctions,
    ChordFrame,
    NodeFrame,
    Polynomials,
    ShapeFunctions,
    Splines,
    in_frame,
)

Array = NDArray[np.float64]
pytestmark = pytest.mark.filterwarnings("ignore:.*(moves freely|static work|spins)")
ELEMENTS = 4


def random_part(rng: np.random.Generator, elements: int = ELEMENTS) -> jo.Part:
    """A beam of any material, section and length along x."""
    material = jo.Material(
        E=rng.uniform(7e10, 2.1e11), nu=rng.uniform(0.2, 0.35), rho=rng.uniform(2500, 8000)
    )
    height = rng.uniform(0.01, 0.02)
    section = jo.Rectangle(height * rng.uniform(1.2, 2.0), height)
    return jo.Part.beam(
        rng.uniform(0.6, 1.4), section, elements, material, theory=jo.parts.EulerBernoulli()
    )


def run(reduced: jo.ReducedPart, support: str, push: Array, t_end: float) -> tuple[Array, Array]:
    """Position of the end and stresses in the middle of a body under a random force."""
    rod = jo.FlexibleBody("rod", reduced)
    signal = jo.Table(np.linspace(0.0, t_end, 9), np.sin(np.linspace(0.0, 2.0 * np.pi, 9)), "cubic")
    load = jo.Force("load", rod["end"], tuple(push), signal=signal)
    items: list[Any] = [rod, load]
    ground = jo.ground["origin"]
    if support == "clamped":
        items.append(jo.Fixed("wall", ground, rod["start"]))
    elif support == "on a ball":
        items.append(jo.Spherical("ball", ground, rod["start"]))
    items.append(jo.PositionSensor("end", rod["end"]))
    sites = ("e2.b.top", "e2.b.left", "e3.a.bottom_right")
    items.append(jo.StressSensor("stress", rod, sites))
    found = jo.simulate(jo.compile(jo.Mechanism(*items)), t_end, output_step=t_end / 40)
    return found["end"] - found["end"][0], found["stress"]


def apart(a: tuple[Array, Array], b: tuple[Array, Array]) -> tuple[float, float]:
    """Largest differences of motion and stress over the largest values."""
    first, second = (
        float(np.abs(x - y).max() / np.abs(y).max()) for x, y in zip(a, b, strict=True)
    )
    return first, second


@pytest.mark.parametrize("support", ["clamped", "on a ball", "free"])
@pytest.mark.parametrize("seed", [1, 2])
def test_one_body_by_all_frames_and_functions(support: str, seed: int) -> None:
    """Whole bases: all modes, all polynomials, all columns; what remains is of second order.

    The deflection is 1e-4 of the length and less, and so are the relative differences: each frame
    is small displacements away from the others. A force ten times smaller shows that it is that
    (`test_the_difference_of_frames_is_of_second_order`).
    """
    rng = np.random.default_rng(seed)
    part = random_part(rng)
    # no more than 0.1 per mille of the length
    stiffness = 3.0 * part.K.diagonal()[2] / 12.0 / ELEMENTS**3
    push = rng.normal(size=3) * 3e-5 * np.ptp(part.nodes[:, 0]) * stiffness
    full = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6 * (ELEMENTS - 1)))
    t_end = 1.0 / jo.reduce(part, jo.FreeFree(modes=1)).frequencies[0]
    truth = run(full, support, push, t_end)
    columns = np.delete(np.eye(part.K.shape[0]), np.arange(6), axis=1)
    bodies = {
        "node": in_frame(full, NodeFrame("start")),
        "end": in_frame(full, NodeFrame("end")),
        "chord": in_frame(full, ChordFrame("start", "end")),
        "free-free": jo.reduce(part, jo.FreeFree(modes=6 * ELEMENTS)),
        "polynomials": jo.reduce(part, ShapeFunctions(Polynomials(ELEMENTS))),
        "columns": jo.reduce(part, ShapeFunctions(columns, frame=AsGiven())),
    }
    for name, body in bodies.items():
        assert body.n == full.n, name
        motion, stress = apart(run(body, support, push, t_end), truth)
        assert motion < 2e-4 and stress < 2e-3, name


def test_the_difference_of_frames_is_of_second_order() -> None:
    """A force a tenth as large leaves a tenth of the relative difference of two frames."""
    rng = np.random.default_rng(7)
    part = random_part(rng)
    full = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))
    held = in_frame(full, NodeFrame("end"))
    t_end = 1.0 / full.frequencies[0]
    push = np.array([0.0, 1.0, 1.0]) * part.K.diagonal()[2] * 1e-5
    differences = [
        apart(run(held, "on a ball", f * push, t_end), run(full, "on a ball", f * push, t_end))
        for f in (1.0, 0.1)
    ]
    assert differences[0][0] > 1e-6
    assert differences[0][0] / differences[1][0] == pytest.approx(10.0, rel=0.3)


@pytest.mark.parametrize("seed", [3, 4])
def test_few_functions_to_the_accuracy_of_the_basis(seed: int) -> None:
    """A cantilever by modes and functions that it can make: a few per cent, and less with more.

    The force swings six times as fast as the cantilever. Of a static deflection the functions from
    the third on have 12/b^4 = 0.3 per cent, at that speed about ten times as much, and of the
    stress the root of that. Free functions bend nothing at the clamp.
    """
    rng = np.random.default_rng(seed)
    part = random_part(rng, 8)
    full = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=42))
    t_end = 1.0 / full.frequencies[0]
    stiffness = 3.0 * part.K.diagonal()[2] / 12.0 / 8**3
    push = np.array([0.0, *rng.normal(size=2)]) * 1e-4 * stiffness
    truth = run(full, "clamped", push, t_end)
    few = {
        "clamped beam functions": (ShapeFunctions(BeamFunctions("clamped-free", 2)), 0.1, 0.6),
        "more of them": (ShapeFunctions(BeamFunctions("clamped-free", 4)), 0.01, 0.1),
        "polynomials": (ShapeFunctions(Polynomials(6)), 0.003, 0.1),
        "splines": (ShapeFunctions(Splines(7, degree=4)), 0.01, 0.15),
        "craig-bampton": (jo.CraigBampton(("start", "end"), modes=2), 0.1, 0.6),
        "free-free with attachments": (
            jo.FreeFree(modes=2, interfaces=("start", "end")),
            0.01,
            0.15,
        ),
    }
    for name, (method, most, stressed) in few.items():
        motion, stress = apart(run(jo.reduce(part, method), "clamped", push, t_end), truth)
        assert motion < most and stress < stressed, (name, motion, stress)
    free = jo.reduce(part, ShapeFunctions(BeamFunctions("free-free", 4)))
    assert apart(run(free, "clamped", push, t_end), truth)[0] > 0.1
