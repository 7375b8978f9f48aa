"""Results files of a simulator that is stepped from outside."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.simulation import Simulator


def cart(stop: float = 1e9) -> jo.Model:
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    place = jo.CoordinateSensor("place", rail.displacement)
    end = jo.mechanism.Event("end", place, threshold=stop, stop=True)
    return jo.compile(jo.Mechanism(body, rail, push, place, end))


def test_a_recorded_controller_is_that_of_simulate_to_the_last_bit(tmp_path: Path) -> None:
    """Held inputs are the same as an array of values for each interval."""
    model, forces = cart(), 3.0 * np.cos(np.arange(50))
    sim = Simulator(model, jo.RK4(0.01), path=tmp_path / "run.h5")
    for force in forces:
        sim.set("force", force)
        sim.step()
    found = sim.close()
    wanted = jo.simulate(model, 0.5, solver=jo.RK4(0.01), inputs={"force": forces})
    assert found is not None and np.array_equal(found.time, wanted.time)
    assert np.array_equal(found["place"], wanted["place"])
    stored = jo.load(tmp_path / "run.h5")
    assert stored.complete and stored.nt == 51 and np.array_equal(stored["place"], wanted["place"])
    assert np.array_equal(stored.energy.work, wanted.energy.work)
    assert sim.close() is None


@pytest.mark.parametrize("every", (1, 3))
def test_rows_do_not_depend_on_how_steps_are_asked_for(tmp_path: Path, every: int) -> None:
    model = cart()
    times = []
    for k, counts in enumerate(([1] * 1200, [1200], [7, 593, 600])):
        with Simulator(model, jo.RK4(0.01), path=tmp_path / f"{k}.h5", every=every) as sim:
            sim.set("force", 1.0)
            for count in counts:
                sim.step(count)
        times.append(jo.load(tmp_path / f"{k}.h5").time)
    exact = 0.01 * every * np.arange(1200 // every + 1)
    for found in times:
        # sums of 1200 steps are rounded
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-11)


def test_events_and_what_led_to_a_failure_are_kept(tmp_path: Path) -> None:
    with Simulator(cart(stop=0.01), jo.RK4(0.01), path=tmp_path / "run.h5") as sim:
        sim.set("force", 8.0)
        sim.step(100)
        assert sim.stopped == "end"
        sim.step(10)
    kept = jo.load(tmp_path / "run.h5")
    assert [event.name for event in kept.events] == ["end"] and kept.time[-1] > 0.1
    sim = Simulator(cart(), jo.RK4(0.01), path=tmp_path / "bad.h5")
    sim.set("force", 1e300)
    with pytest.raises(jo.SimulationError):
        sim.step(1000)
    kept = jo.load(tmp_path / "bad.h5")
    assert kept.nt >= 1 and not kept.complete and "failed" in kept.attributes["ended"]


def test_nothing_is_written_before_the_first_step(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(b"older")
    Simulator(cart(), path=path).close()
    assert path.read_bytes() == b"older" and len(list(tmp_path.iterdir())) == 1
    for every in (0, 1.5, True):
        with pytest.raises(jo.InputError, match="every is"):
            Simulator(cart(), path=path, every=every)  # type: ignore[arg-type]
