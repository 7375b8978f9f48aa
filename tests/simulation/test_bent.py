"""Linear modes that bend far at rest: what they miss, and that the user is told."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.check_bending import turn_within

LENGTH = 1.0
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.02, 0.002)
EI = 210e9 * 0.02 * 0.002**3 / 12.0
ROD = jo.reduce(
    jo.Part.beam(LENGTH, SECTION, 20, STEEL, theory=jo.parts.EulerBernoulli()),
    jo.CraigBampton(("start", "end"), modes=4),
)


def cantilever(alpha: float) -> jo.Model:
    """A leaf spring that a force of alpha EI / L^2 bends at its end."""
    body = jo.FlexibleBody("leaf", ROD)
    return jo.compile(
        jo.Mechanism(
            body,
            jo.Fixed("weld", jo.ground["origin"], body["start"]),
            jo.Force("push", body["end"], (0.0, 0.0, alpha * EI / LENGTH**2)),
        )
    )


@pytest.mark.parametrize("alpha", [1.5, 4.0])
def test_a_cantilever_that_bends_by_half_its_length_is_told(alpha: float) -> None:
    # linear: the end moves by alpha L / 3 and turns by alpha / 2, here up to 1.33 L; the elastica
    # of alpha = 1.5 moves by 0.411 L only (Bisshopp and Drucker 1945, figure 2)
    with pytest.warns(jo.JoustoWarning, match="'leaf' bends by .* rad within itself") as said:
        state = jo.equilibrium(cantilever(alpha))
    (message,) = [str(w.message) for w in said]
    told = float(message.split("bends by ")[1].split(" rad")[0])
    # at most the linear turn; the force turns in the frame that the clamp holds, and bends less
    assert 0.25 * alpha < told <= 0.5 * alpha
    assert "Beam" in message and state.q.shape == (7 + ROD.n,)


def test_a_small_bending_is_left_alone() -> None:
    model = cantilever(0.5)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        state = jo.equilibrium(model)
    assert not said
    # linear: the end turns by 0.25 rad within the leaf, a bit less as the force turns
    assert 0.125 < turn_within(model.shapes[0], state.q[7:]) <= 0.25


def test_a_rotation_of_the_frame_is_no_bending() -> None:
    model = cantilever(0.5)
    shape = model.shapes[0]
    p = jo.equilibrium(model).q[7:]
    # modes with a small rigid rotation added, as from another frame
    spin = np.cross([0.1, -0.2, 0.3], shape.nodes)
    turned = jo.model.model.Shape(
        shape.kind, shape.nodes, shape.elements, shape.modes + spin[:, :, None], shape.stress
    )
    assert turn_within(turned, p) == pytest.approx(turn_within(shape, p), rel=1e-12)
