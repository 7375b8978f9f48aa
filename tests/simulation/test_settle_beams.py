"""The rest of slender beams far from where they are placed."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo


def strip(elements: int) -> jo.Model:
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    beam = jo.BeamBody(
        "strip",
        [(0, 0, 0), (1, 0, 0)],
        jo.Rectangle(0.02, 0.0005),
        steel,
        elements=elements,
        bending=True,
    )
    return jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
            jo.Gravity((0, 0, -9.81)),
            jo.PositionSensor("tip", beam["end"]),
        )
    )


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_level_strip_finds_its_rest_hanging() -> None:
    """The same as by bringing the weight on in steps, and nothing moves from there."""
    model = strip(5)
    rest = jo.equilibrium(model)
    stepped = jo.simulation.load_path(model, "gravity", to=1.0).states[-1]
    assert rest.q == pytest.approx(stepped.q, abs=1e-9)
    assert rest.q[5 * 7 + 2] < -0.7  # m, of the last node
    run = jo.simulate(model, 0.02, solver=jo.GeneralizedAlpha(step=2e-3), state=rest)
    assert np.ptp(run["tip"], axis=0).max() < 1e-7


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_beams_between_two_clamps_with_redundant_rows_rest() -> None:
    """Two welds of the same end: rows repeat one another, the dense way finds the rest."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    beam = jo.BeamBody("bar", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), steel, elements=3)
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed("one", jo.ground["origin"], beam["start"]),
            jo.Fixed("two", jo.ground["origin"], beam["start"]),
            jo.Gravity((0, 0, -9.81)),
            jo.PositionSensor("tip", beam["end"]),
        )
    )
    rest = jo.equilibrium(model)
    single = jo.equilibrium(
        jo.compile(
            jo.Mechanism(
                beam,
                jo.Fixed("one", jo.ground["origin"], beam["start"]),
                jo.Gravity((0, 0, -9.81)),
            )
        )
    )
    assert rest.q == pytest.approx(single.q, abs=1e-9)
