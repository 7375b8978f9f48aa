"""verify on six machines: without a fault they agree, a planted one is found, its reading named.

The faults stand in the numbers that the engine gets; the moving frame reads the declarations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.model import compile as compile_room
from jousto.model.packing import builder
from jousto.natural.verification import Verification
from jousto.natural.verify import verify
from natural.machines import rod

Patch = pytest.MonkeyPatch
Plant = Callable[[Patch], None]
pytestmark = pytest.mark.filterwarnings(
    "ignore:.*has no joint to another", "ignore:.*regularised friction"
)

X, Y, Z = np.eye(3)
WEIGHT = jo.Gravity((0, 0, -9.81))


def top(_: jo.ReducedPart) -> jo.Mechanism:
    """A heavy top that stands oblique on its tip."""
    body = jo.RigidBody(
        "top",
        0.5,
        (4e-4, 4e-4, 5e-4),
        center=(0, 0, 0.06),
        orientation=jo.Rotate(X, degrees=25),
        angular_velocity=150.0 * np.array([0, -np.sin(np.radians(25)), np.cos(np.radians(25))]),
    )
    tip = jo.Spherical("tip", jo.ground["origin"], body["origin"])
    return jo.Mechanism(body, tip, WEIGHT, jo.OrientationSensor("turned", body["origin"]))


def shaft(part: jo.ReducedPart) -> jo.Mechanism:
    """A soft beam that spins freely about its own axis and whirls."""
    whirl = np.zeros(len(part.stiffness))
    whirl[:4] = 0.3
    beam = jo.FlexibleBody("shaft", part, angular_velocity=60.0 * X, modal_velocities=whirl)
    bend = jo.PositionSensor("bend", beam["end"], relative_to=beam["start"])
    return jo.Mechanism(beam, WEIGHT, bend)


def slider_crank(part: jo.ReducedPart) -> jo.Mechanism:
    """A crank that turns evenly, a soft rod and a heavy slider."""
    speed = 30.0
    crank = jo.RigidBody(
        "crank", 1.0, (0.002, 0.01, 0.01), angular_velocity=speed * Z, markers={"pin": (0.2, 0, 0)}
    )
    link = jo.FlexibleBody(
        "rod",
        part,
        position=(0.2, 0, 0),
        velocity=0.2 * speed * Y,
        angular_velocity=-0.2 * speed * Z,
    )
    slider = jo.RigidBody("slider", 5.0, (0.02, 0.02, 0.02), position=(1.2, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], crank["origin"], axis=Z)
    pin = jo.Revolute("pin", crank["pin"], link["start"], axis=Z)
    wrist = jo.Spherical("wrist", link["end"], slider["origin"])
    guide = jo.Prismatic("guide", jo.ground["origin"], slider["origin"], axis=X)
    motor = jo.Drive("motor", hinge.angle, jo.ConstantSpeed(speed))
    stress = jo.StressSensor("stress", link, "e2.a.left")
    return jo.Mechanism(crank, link, slider, hinge, pin, wrist, guide, motor, WEIGHT, stress)


def four_bar(part: jo.ReducedPart) -> jo.Mechanism:
    """Two rigid uprights that swing, and a soft beam across that a force bends sideways."""
    spin = 4.0 * Y
    left, right = (
        jo.RigidBody(
            name,
            2.0,
            (0.1, 0.1, 0.01),
            center=(0, 0, 0.4),
            position=place,
            angular_velocity=spin,
            markers={"head": (0, 0, 0.8)},
        )
        for name, place in (("left", (0, 0, 0)), ("right", (1, 0, 0)))
    )
    deck = jo.FlexibleBody("deck", part, position=(0, 0, 0.8), velocity=0.8 * 4.0 * X)
    foot = jo.Revolute("left foot", jo.ground["origin"], left["origin"], axis=Y)
    second = jo.Revolute("right foot", jo.ground.at((1, 0, 0)), right["origin"], axis=Y)
    knee = jo.Revolute("knee", left["head"], deck["start"], axis=Y)
    hang = jo.Spherical("hang", deck["end"], right["head"])
    push = jo.Force("push", deck["node3"], (0, 30.0, 0))
    tip = jo.OrientationSensor("end of the deck", deck["end"])
    return jo.Mechanism(left, right, deck, foot, second, knee, hang, push, WEIGHT, tip)


def block(_: jo.ReducedPart) -> jo.Mechanism:
    """A block that slides up a slope and rubs."""
    slope = np.array([np.cos(0.4), 0, np.sin(0.4)])
    body = jo.RigidBody("block", 3.0, (0.01, 0.01, 0.01), velocity=2.0 * slope)
    guide = jo.Prismatic("slope", jo.ground["origin"], body["origin"], axis=slope)
    law = jo.mechanism.Regularised(velocity=0.05)
    rub = jo.Friction("rub", guide, 0.3, law=law)
    way = jo.PositionSensor("way", body["origin"])
    return jo.Mechanism(body, guide, rub, WEIGHT, way, jo.ForceSensor("rubbing", rub))


def pendulum(part: jo.ReducedPart) -> jo.Mechanism:
    """A soft beam that swings from a pin."""
    beam = jo.FlexibleBody("beam", part, angular_velocity=(0, -3.0, 2.0))
    pin = jo.Spherical("pin", jo.ground["origin"], beam["start"])
    middle = jo.AccelerationSensor("middle", beam["node3"])
    return jo.Mechanism(beam, pin, WEIGHT, middle, jo.PositionSensor("end", beam["end"]))


def spoilt(name: str, change: Callable[[Any], dict[str, Any]]) -> Plant:
    """Return what changes arrays of bodies, `_rigid` or `_flexible`, on their way to the engine."""

    def plant(patch: Patch) -> None:
        made = getattr(compile_room, name)

        def wrong(*given: Any) -> Any:
            model = made(*given)
            return replace(model, **change(model))

        patch.setattr(compile_room, name, wrong)

    return plant


def marker_rotation(patch: Patch) -> None:
    """Markers at flexible nodes turn the other way."""
    made = builder.MarkerModel

    def wrong(
        body: int, turns: bool, u0: Any, A0: Any, Phi: Any, Psi: Any, chi: Any, **more: Any
    ) -> Any:
        return made(body, turns, u0, A0, Phi, None if Psi is None else -Psi, chi, **more)

    patch.setattr(builder, "MarkerModel", wrong)


def friction_sign(patch: Patch) -> None:
    """Friction pushes instead of holding."""
    made = builder.packed

    def wrong(struct: str, *rest: Any, **data: Any) -> Any:
        if struct == "jo_friction_data":
            data |= {"mu_kinetic": -data["mu_kinetic"], "mu_static": -data["mu_static"]}
        return made(struct, *rest, **data)

    patch.setattr(builder, "packed", wrong)


def heavy_mode(part: jo.ReducedPart) -> jo.ReducedPart:
    """The part with 2 % more mass in its first mode than the engine takes for granted, 1."""
    E = np.array(part.invariants.E)
    E[0, 0] *= 1.02
    return replace(part, invariants=replace(part.invariants, E=E))


@dataclass(frozen=True)
class Fault:
    """A machine of a part, what is wrong with it or its part, and the reading that shows it."""

    machine: Callable[[jo.ReducedPart], jo.Mechanism]
    shown: str
    plant: Plant | None = None
    part: Callable[[], jo.ReducedPart] = rod


CASES = {
    "inertia": Fault(
        top,
        "acceleration of top.center",
        spoilt("_rigid", lambda m: {"J0": m.J0 * (1.01, 1, 1, 1, 1, 1)}),
    ),
    "Coriolis": Fault(
        shaft, "acceleration of shaft.node1", spoilt("_flexible", lambda m: {"EB": -m.EB})
    ),
    "I9": Fault(
        slider_crank,
        "angular acceleration of rod.node5",
        spoilt("_flexible", lambda m: {"ED": 0 * m.ED}),
    ),
    "marker rotation": Fault(four_bar, "knee", marker_rotation),
    "friction sign": Fault(block, "rubbing", friction_sign),
    "mass of a mode": Fault(
        pendulum, "angular acceleration of beam.node2", part=lambda: heavy_mode(rod())
    ),
}


def found(mechanism: jo.Mechanism) -> Verification:
    """Verification over 20 ms, in which soft beams bend by centimetres."""
    return verify(mechanism, 0.02, step=1e-3)


@pytest.mark.parametrize("case", CASES)
def test_a_sound_machine_agrees(case: str) -> None:
    result = found(CASES[case].machine(rod()))
    assert result.agrees, result
    assert all(row.at_instants < 1e-7 for row in result.rows if not np.isnan(row.at_instants))


@pytest.mark.parametrize("case", CASES)
def test_a_planted_fault_is_found_and_named(case: str, monkeypatch: Patch) -> None:
    fault = CASES[case]
    if fault.plant:
        fault.plant(monkeypatch)
    result = found(fault.machine(fault.part()))
    assert not result.agrees
    assert "DISAGREE" in result.verdict
    named = result.open_joints[0] if result.open_joints else result.different[0].name
    assert named == fault.shown, result
    assert f"'{named}'" in result.verdict


def bearing() -> jo.Mechanism:
    """A bar that turns on a pin and rubs."""
    bar = jo.RigidBody("bar", 2.0, (0.02,) * 3, center=(0.3, 0, 0), angular_velocity=5.0 * Z)
    pin = jo.Revolute("pin", jo.ground["origin"], bar["origin"], axis=Z)
    law = jo.mechanism.Regularised(velocity=0.01)
    rub = jo.Friction("rub", pin, 0.3, radius=0.5, law=law)
    return jo.Mechanism(bar, pin, rub, jo.Gravity((0, -9.81, 0)))


LONG_ENOUGH = {"t_end": 0.8, "step": 5e-3}
"""Length and longest step (s) of runs in which friction that pushes has made the engine stop."""


def test_a_fault_that_stops_the_run_is_named_too(monkeypatch: Patch) -> None:
    """Friction that pushes turns the bar faster and faster, until the engine stops at 0.7 s."""
    friction_sign(monkeypatch)
    result = verify(bearing(), **LONG_ENOUGH)
    assert not result.agrees
    assert result.verdict.startswith("the formulations DISAGREE: 'force of rub' differs by ")
    assert "; besides, the engine with a step of " in result.verdict


def test_without_the_fault_the_run_reaches_its_end() -> None:
    assert verify(bearing(), **LONG_ENOUGH).agrees
