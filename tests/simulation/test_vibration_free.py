"""vibration_free_state: driven and pushed elastic machines that start without ringing."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from model.test_initial import four_bar

Z = (0, 0, 1)
STEEL = jo.Material(210e9, 0.3, 7850.0)
LENGTH, WIDTH = 1.0, 0.02  # m


def arm(**options: object) -> jo.FlexibleBody:
    """A strip of steel, its first frequency as a cantilever near 16 Hz."""
    part = jo.Part.beam(LENGTH, jo.Rectangle(WIDTH, WIDTH), 8, STEEL)
    method = jo.CraigBampton(("start", "end"), modes=4)
    return jo.FlexibleBody("arm", jo.reduce(part, method, **options))


def turning(*forces: object, speed: float | None = None, **options: object) -> jo.Model:
    body = arm(**options)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], Z)
    drive = () if speed is None else (jo.Drive("motor", hinge.angle, jo.ConstantSpeed(speed)),)
    items = [f(hinge) if callable(f) else f for f in forces]
    tip = jo.PositionSensor("tip", body["end"])
    sensors = tip, jo.mechanism.ModalSensor("modes", body)
    return jo.compile(jo.Mechanism(body, hinge, *drive, *items, *sensors))


def ringing(run: jo.Solution, speed: float) -> float:
    """What is left of the modal coordinates beside a mean and eight harmonics of the speed."""
    turn = speed * run.time[:, None] * np.arange(9)
    wave = np.hstack([np.cos(turn), np.sin(turn[:, 1:])])
    p = run["modes"]
    return float(np.abs(p - wave @ np.linalg.lstsq(wave, p, rcond=None)[0]).max())


def test_a_beam_under_its_weight_turns_without_ringing() -> None:
    speed = 5.0  # rad/s, a twentieth of the first frequency
    model = turning(jo.Gravity((0, -9.81, 0)), speed=speed)
    end, solver = 1.25, jo.RK4(2e-5)  # a turn
    plain = ringing(jo.simulate(model, end, solver=solver, output_step=1e-3), speed)
    calm = jo.simulate(
        model, end, solver=solver, output_step=1e-3, state=jo.simulation.vibration_free_state(model)
    )
    assert ringing(calm, speed) < 1e-4 * plain


def test_centrifugal_stretch_is_there_from_the_start() -> None:
    """A bar that turns steadily stretches by rho W^2 L^3 / 3E and stays as it is."""
    speed = 30.0
    model = turning(speed=speed)
    state = jo.simulation.vibration_free_state(model)
    run = jo.simulate(model, 0.1, solver=jo.RK4(1e-5), output_step=1e-3, state=state)
    p = run["modes"]
    assert np.abs(p - p[0]).max() < 1e-6 * np.abs(p[0]).max()
    rigid = jo.simulate(model, 0.1, solver=jo.RK4(1e-5), output_step=1e-3)["modes"]
    assert np.abs(rigid - rigid[0]).max() > 0.5 * np.abs(p[0]).max()
    stretch = np.linalg.norm(run["tip"], axis=1) - LENGTH
    # 8 linear elements: a uniform load along the bar is exact at its nodes
    assert stretch == pytest.approx(7850 * speed**2 * LENGTH**3 / (3 * 210e9), rel=1e-4)


def test_a_motor_bends_its_arm_from_the_start() -> None:
    """Inertia load m a x of a hinged bar under a torque: w(L) = 11 m a L^5 / 120 EI (Roark)."""
    torque = 20.0  # N m
    model = turning(lambda hinge: jo.JointForce("motor", hinge.angle, torque))
    state = jo.simulation.vibration_free_state(model)
    area, inertia = WIDTH**2, WIDTH**4 / 12
    mass = 7850 * area
    acceleration = 3 * torque / (mass * LENGTH**3)
    bent = 11 * mass * acceleration * LENGTH**5 / (120 * 210e9 * inertia)
    # the tip lies behind the tangent at the hinge
    body = arm()
    reduced = body.reduced
    p = state.q[7:]
    first, last = reduced.node("start"), reduced.node("end")
    u = reduced.modes @ p
    lean = reduced.rotation(first) @ p
    w = u[last, 1] - u[first, 1] - LENGTH * lean[2]
    assert w == pytest.approx(-bent, rel=2e-3)  # slender bar: shear gives 1e-3
    calm = jo.simulate(model, 0.2, solver=jo.RK4(1e-5), output_step=1e-3, state=state)["modes"]
    rings = jo.simulate(model, 0.2, solver=jo.RK4(1e-5), output_step=1e-3)["modes"]
    assert np.ptp(rings, axis=0).max() > 1.5 * np.abs(p).max()  # to twice the bending and back
    smooth = np.polynomial.chebyshev.chebfit(np.linspace(-1, 1, len(calm)), calm, 4)
    smooth = np.polynomial.chebyshev.chebval(np.linspace(-1, 1, len(calm)), smooth).T
    assert np.abs(calm - smooth).max() < 1e-2 * np.abs(p).max()


@pytest.mark.parametrize("driven", [True, False])
def test_a_flexible_four_bar_starts_calmly(driven: bool) -> None:
    speed = 15.0
    items, joints = four_bar(flexible=True)
    start: object = jo.Initial(joints["main"].angle, rate=speed)
    if driven:
        start = jo.Drive("motor", joints["main"].angle, jo.ConstantSpeed(speed))
    modal = [jo.mechanism.ModalSensor(f"modes of {b.name}", b) for b in items[:3]]
    model = jo.compile(jo.Mechanism(*items, start, *modal))
    state = jo.simulation.vibration_free_state(model)
    solver = jo.RK4(2e-6)
    runs = [
        jo.simulate(model, 0.01, solver=solver, output_step=2e-5, state=s) for s in (None, state)
    ]

    def shake(run: jo.Solution) -> float:
        """Modal coordinates beside their slow change, a polynomial over a 40th of a turn."""
        p = np.hstack([run[f"modes of {b.name}"] for b in items[:3]])
        x = np.linspace(-1, 1, len(p))
        slow = np.polynomial.chebyshev.chebval(x, np.polynomial.chebyshev.chebfit(x, p, 6)).T
        return float(np.abs(p - slow).max())

    assert shake(runs[1]) < 1e-3 * shake(runs[0])
    # the start is the one that was asked for; at rest the crank bends by less than 1e-3
    assert state.v[model.bodies[0].iv + 5] == pytest.approx(speed, rel=1e-3)


def test_rigid_machines_are_left_alone() -> None:
    items, joints = four_bar()
    model = jo.compile(jo.Mechanism(*items, jo.Initial(joints["main"].angle, rate=3.0)))
    state = jo.simulation.vibration_free_state(model)
    assert np.abs(state.v - model.v0).max() < 1e-14
    assert np.abs(state.q - model.q0).max() < 1e-14


def test_exact_beams_are_refused() -> None:
    section = jo.mechanism.BeamSection.of(jo.Circle(0.01), STEEL)
    beam = jo.BeamBody("cable", [(0, 0, 0), (1, 0, 0)], section, elements=2)
    hook = jo.Spherical("hook", jo.ground["origin"], beam["start"])
    model = jo.compile(jo.Mechanism(beam, hook, jo.Gravity((0, 0, -9.81))))
    with pytest.raises(jo.InputError, match="exact beams are not supported"):
        jo.simulation.vibration_free_state(model)


def chain_below_a_boom(mass: float) -> jo.Model:
    """Three links below an elastic boom, the last of a given mass, which bends it."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    boom = jo.Part.beam(length=4.0, section=jo.Box(0.1, 0.1, web=0.005), elements=8, material=steel)
    reduced = jo.reduce(boom, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    body = jo.FlexibleBody("boom", reduced, orientation=jo.Rotate((0, 1, 0), degrees=-30))
    items = [body, jo.Fixed("clamp", jo.ground["origin"], body["start"])]
    hook, place = body["end"], np.array(body["end"].r)
    for k in range(3):
        heavy = mass if k == 2 else 0.5
        link = jo.RigidBody(
            f"link{k}", heavy, (heavy, heavy, 0.1 * heavy), center=(0, 0, -0.25),
            markers={"top": (0, 0, 0), "low": (0, 0, -0.5)},
            position=place - (0, 0, 0.5 * k),
        )  # fmt: skip
        items += [link, jo.Spherical(f"pin{k}", hook, link["top"])]
        hook = link["low"]
    items += [jo.Gravity((0, 0, -9.81)), jo.ReactionSensor("N", items[3])]
    return jo.compile(jo.Mechanism(*items))


def test_a_chain_that_nothing_drives_carries_its_weight() -> None:
    model = chain_below_a_boom(20.0)
    run = jo.simulate(model, 1e-3, state=jo.simulation.vibration_free_state(model))
    assert abs(run["N"][0, 2]) == pytest.approx(9.81 * 21.0, rel=0.02)


def test_a_chain_that_swings_too_fast_is_refused() -> None:
    """A heavy load bends the boom, which kinks the chain; its swing once gave a third of m g."""
    with pytest.raises(jo.SimulationError, match="swings too fast .* equilibrium"):
        jo.simulation.vibration_free_state(chain_below_a_boom(300.0))
