"""A part driven alone by a run (Altarriba 2010, eq. 42)."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import jousto as jo

RUBBER = jo.Material(E=2e9, nu=0.3, rho=1100.0)
STIFF = jo.Material(E=200e9, nu=0.3, rho=1100.0)


def spinning(speed):
    """Return the run of a rigid rod of 1 m that spins evenly, with the reaction of its hinge."""
    mass = 1100.0 * 0.02 * 0.02
    arm = jo.RigidBody("arm", mass, (1e-3, mass / 12, mass / 12), center=(0.5, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 0, 1))
    even = jo.Drive("even", pin.angle, jo.Ramp(-1.0, 1.0, before=-speed, after=speed))
    model = jo.compile(jo.Mechanism(arm, pin, even, jo.ReactionSensor("pin", pin)))
    return jo.simulation.kinematics(model, np.linspace(0.0, 0.02, 201))


def rod(modes=4, material=RUBBER):
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 8, material, name="rod")
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes))


def test_a_spinning_rod_is_stretched_by_its_own_mass():
    """N(x) = rho A w^2 (L^2 - x^2) / 2 stretches it by rho w^2 L^3 / 3E; linear, so small."""
    speed, part = 20.0, rod()
    run = spinning(speed)
    p = jo.twin.drive_part(run, "arm", part, {"start": run["pin"]})
    ends = part.modes[[part.node("start"), part.node("end")], 0]
    stretch = (ends[1] - ends[0]) @ p.T
    exact = 1100.0 * speed**2 / (3 * 2e9)
    # less the centrifugal force of the stretch itself, and differences over 0.1 ms
    np.testing.assert_allclose(stretch, exact, rtol=2e-4)


def pendulum():
    """Return a model of a soft flexible rod that falls, with the reaction of its hinge."""
    arm = jo.FlexibleBody("arm", rod(2), damping=0.1)
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    sensor = jo.ReactionSensor("pin", pin)
    return jo.compile(jo.Mechanism(arm, pin, jo.Gravity((0, 0, -9.81)), sensor))


def test_the_part_of_the_run_itself_moves_as_in_the_run():
    """The same part under its own motion and reactions: the difference falls with h^2."""
    model, part = pendulum(), rod(2)
    errors = []
    for h in (2e-3, 1e-3):
        run = jo.simulate(model, 0.2, solver=jo.RK4(step=2e-5), output_step=h)
        shape = run.bodies[0]
        own = run.q[:, shape.q_offset + 7 : shape.q_offset + 7 + part.n]
        p = jo.twin.drive_part(run, "arm", part, {"start": run["pin"]}, damping=0.1,
                               start=(own[0], 0 * own[0]))  # fmt: skip
        soft = int(np.argmax(np.abs(own).max(axis=0)))
        errors.append(np.abs(p - own)[:, soft].max() / np.abs(own[:, soft]).max())
    assert errors[1] < 0.02
    assert errors[1] < 0.35 * errors[0]


def driven(mass=1100.0 * 0.02 * 0.02):
    """Return the run of a rigid rod that a drive swings up, with hinge reaction and drive moment.

    The loads at its hinge in world axes, (nt, 6): the moment of the drive is about y.
    """
    arm = jo.RigidBody("arm", mass, (1e-3, mass / 12, mass / 12), center=(0.5, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["origin"], axis=(0, 1, 0))
    motor = jo.Drive("motor", pin.angle, jo.SCurve((0.0, 1.0), (0.0, 1.0)))
    sensors = jo.ReactionSensor("pin", pin), jo.ReactionSensor("motor", motor)
    model = jo.compile(jo.Mechanism(arm, pin, motor, jo.Gravity((0, 0, -9.81)), *sensors))
    run = jo.simulation.kinematics(model, np.linspace(0.0, 1.0, 501))
    turning = np.zeros((len(run.time), 6))
    turning[:, 4] = run["motor"][:, 0]
    return run, run["pin"], turning


def test_a_forgotten_moment_is_refused_and_named():
    """About its hinge the rod needs ``J th'' + m g x / 2``: all of it is the motor's."""
    run, hinge, turning = driven()
    part = rod(material=STIFF)
    p = jo.twin.drive_part(run, "arm", part, {"start": hinge + turning})
    assert np.abs(p).max() > 0.0
    with pytest.raises(jo.InputError, match="loads do not balance") as caught:
        jo.twin.drive_part(run, "arm", part, {"start": hinge})
    found = re.search(r"at ([\d.]+) s .* a moment of \(0, (\S+), 0\) N m more", str(caught.value))
    assert found and "a force of" not in str(caught.value)
    k = int(np.argmin(np.abs(run.time - float(found[1]))))
    # the section's own inertia, h^2 / L^2, and the rod's sag of 2e-4 m are left out
    assert float(found[2]) == pytest.approx(turning[k, 4], rel=1e-3)


def test_all_loads_of_a_run_need_no_sensors():
    """`loads_of` finds the hinge and the motor, also of the part with an interface elsewhere."""
    run, hinge, turning = driven()
    part = rod(material=STIFF)
    given = jo.twin.drive_part(run, "arm", part, {"start": hinge + turning})
    loads = jo.recovery.loads_of(run, "arm")
    found = jo.twin.drive_part(run, "arm", part, loads)
    np.testing.assert_allclose(found, given, atol=1e-9 * np.abs(given).max())
    np.testing.assert_array_equal(
        jo.twin.drive_part(run, "arm", part, loads.resolved("world")).round(12), found.round(12)
    )
    with pytest.raises(jo.InputError, match="other instants than the run"):
        jo.twin.drive_part(run, "arm", part, jo.recovery.loads_of(run, "arm", [0.5]))
    far = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 8, STIFF, name="far")
    moved = replace(far, nodes=far.nodes + (0.0, 0.01, 0.0))
    elsewhere = jo.reduce(moved, jo.CraigBampton(("start", "end"), modes=4))
    with pytest.raises(jo.InputError, match=r"load 'pin' acts at arm.origin, 0.01 m from"):
        jo.twin.drive_part(run, "arm", elsewhere, loads)


def test_a_reaction_of_the_other_body_and_another_mass_are_named():
    run, hinge, turning = driven()
    with pytest.raises(jo.InputError, match="a force of .* and a moment of"):
        jo.twin.drive_part(run, "arm", rod(), {"start": -hinge - turning})
    light, hinge, turning = driven(0.8 * 1100.0 * 0.02 * 0.02)
    with pytest.raises(jo.InputError, match="a force of"):
        jo.twin.drive_part(light, "arm", rod(), {"start": hinge + turning})
    nearly, hinge, turning = driven(0.96 * 1100.0 * 0.02 * 0.02)
    with pytest.warns(jo.JoustoWarning, match=r"a force of .* 2% of all loads"):
        jo.twin.drive_part(nearly, "arm", rod(), {"start": hinge + turning})


def test_what_does_not_fit_is_named():
    run, part = spinning(20.0), rod()
    with pytest.raises(jo.InputError, match=r"loads\['start'\] has shape \(3, 6\), must be"):
        jo.twin.drive_part(run, "arm", part, {"start": np.zeros((3, 6))})
    with pytest.raises(jo.InputError, match="no node 'strat'; did you mean 'start'"):
        jo.twin.drive_part(run, "arm", part, {"strat": run["pin"]})
    with pytest.raises(jo.InputError, match="start has 1 arrays, must be coordinates and vel"):
        jo.twin.drive_part(run, "arm", part, {"start": run["pin"]}, start=(np.zeros(part.n),))
    with pytest.raises(jo.InputError, match="no body 'arn'"):
        jo.twin.drive_part(run, "arn", part, {})
