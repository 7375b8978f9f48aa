"""Variants of a mechanism: rigid bodies and fewer modes for every kind of sensor."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.body_variants import with_modes, with_rigid_bodies
from scene.machines import everything

# five steps while the tip is still deep in its floor
UNTIL, STEPS = 1e-4, jo.GeneralizedAlpha(step=2e-5)

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")


def test_all_modes_are_the_machine() -> None:
    given = everything()
    kept = with_modes(given, {"arm": range(given.bodies[0].n)})
    assert not kept.dropped
    one, other = (jo.simulate(jo.compile(m), UNTIL, solver=STEPS) for m in (given, kept.mechanism))
    for name in one.sensors:
        assert np.array_equal(one[name], other[name]), name


def test_every_sensor_follows_its_body_with_fewer_modes() -> None:
    """Stress, gauges and modal loads have as many modes as the body: a run of it has them all."""
    few = with_modes(everything(), {"arm": [0, 2, 4]})
    run = jo.simulate(jo.compile(few.mechanism), UNTIL, solver=STEPS)
    assert not few.dropped
    assert run["modal loads"].shape[1] == 3 and run["modal"].shape[1] == 6
    for name in run.sensors:
        assert np.isfinite(run[name]).all(), name


def test_what_measures_deformation_is_dropped_with_it() -> None:
    given = everything()
    needs = ("suction", "walker")  # loads on the modes, and one that moves along them
    items = [x for x in given.items if getattr(x, "name", "") not in needs]
    stiff = with_rigid_bodies(jo.Mechanism(*items), ["arm"])
    assert {"modal", "momentum", "modal loads", "stress", "mises", "gauge"} <= set(stiff.dropped)
    assert "loads" not in stiff.dropped
    run = jo.simulate(jo.compile(stiff.mechanism), UNTIL, solver=STEPS)
    assert np.isfinite(run["loads"]).all()
