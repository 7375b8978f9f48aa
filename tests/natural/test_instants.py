"""Both formulations read the same at the same state, without any step of time.

1e-8 of the size of each value: the multipliers of the second formulation are found by iteration
with a penalty of 1e6, which leaves some 1e-10.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.natural.added_sensors import largest_of, typical_sizes, with_added_sensors
from jousto.natural.sensors_at_state import at_states
from jousto.natural.verify import by_engine
from natural.machines import differences, everything, read, rod, rssr

SAME = 1e-8
# compile closes velocities that joints change, and says so
pytestmark = pytest.mark.filterwarnings(
    "ignore:.*contradict the joints", "ignore:.*is not an interface"
)


def compared(mechanism: jo.Mechanism, t_end: float = 0.05) -> dict[str, float]:
    run = jo.simulate(
        jo.compile(mechanism), t_end, solver=jo.RK4(2e-4), output_step=round(t_end / 5, 6)
    )
    return dict(differences(mechanism, run))


def test_forces_sensors_and_modes_of_every_kind() -> None:
    found = compared(everything())
    assert {name: d for name, d in found.items() if not d < SAME} == {}


FLYING: dict[str, Any] = {
    "fixed": lambda a, b: jo.Fixed("j", a, b),
    "constant orientation": lambda a, b: jo.ConstantOrientation("j", a, b),
    "prismatic": lambda a, b: jo.Prismatic("j", a, b, axis=(1, 0, 1)),
    "planar": lambda a, b: jo.Planar("j", a, b, normal=(1, 2, 1)),
    "revolute": lambda a, b: jo.Revolute("j", a, b, axis=(1, 2, 1)),
    "cylindrical": lambda a, b: jo.Cylindrical("j", a, b, axis=(0, 2, 1)),
    "screw": lambda a, b: jo.Screw("j", a, b, 0.4, axis=(0, 2, 1)),
    "universal": lambda a, b: jo.Universal("j", a, b, axis_a=(0, 2, 1)),
    "spherical": lambda a, b: jo.Spherical("j", a, b),
    "point on line": lambda a, b: jo.PointOnLine("j", a, b, axis=(0, 2, 1)),
    "point on plane": lambda a, b: jo.PointOnPlane("j", a, b, normal=(0, 2, 1)),
}


@pytest.mark.parametrize("kind", FLYING)
def test_joints_between_bodies_that_fly(kind: str) -> None:
    """A bent bar and a rigid body, all rows and the reaction in two frames."""
    bar = jo.FlexibleBody(
        "bar", rod(), modal_velocities=np.full(7, 0.3), angular_velocity=(3, 1, -2)
    )
    ball = jo.RigidBody(
        "ball",
        3.0,
        (0.02, 0.03, 0.04),
        center=(0.1, 0.2, 0),
        position=(1, 0, 0),
        velocity=(0.3, 0, 1),
    )
    joint = FLYING[kind](bar["end"], ball["origin"])
    sensors = (
        jo.ReactionSensor("reaction", joint),
        jo.ReactionSensor("in joint", joint, resolved_in="joint"),
        jo.AccelerationSensor("a", ball["center"]),
        jo.mechanism.ModalSensor("p", bar),
    )
    pull = jo.Force("pull", ball["center"], (30, -20, 10))
    turn = jo.Torque("turn", bar["start"], (3, 20, -10))
    machine = jo.Mechanism(bar, ball, joint, pull, turn, jo.Gravity((0, 0, -9.81)), *sensors)
    assert {name: d for name, d in compared(machine).items() if not d < SAME} == {}


def couplings() -> jo.Mechanism:
    """Two wheels in gear, a rack on the second and a rod from it to a slide."""
    z = (0, 0, 1)
    wheels = [jo.RigidBody(f"wheel {i}", 2.0, (0.1, 0.1, 0.2), position=(i, 0, 0)) for i in (0, 1)]
    axles = [
        jo.Revolute(f"axle {i}", jo.ground.at((i, 0, 0)), wheel["origin"], axis=z)
        for i, wheel in enumerate(wheels)
    ]
    bar = jo.RigidBody("bar", 1.0, (0.1, 0.1, 0.1), position=(1, 1, 0))
    slide = jo.Prismatic("slide", jo.ground.at((1, 1, 0)), bar["origin"], axis=(1, 0, 0))
    weight = jo.RigidBody("weight", 1.5, (0.1, 0.1, 0.1), position=(1, 0.4, -0.9))
    rod = jo.Rod("rod", wheels[1].at((0.3, 0, 0)), weight["origin"])
    gear = jo.Gear("gear", axles[0].angle, axles[1].angle, -0.5)
    rack = jo.Rack("rack", axles[1].angle, slide.displacement, 0.2)
    push = jo.JointForce("push", axles[0].angle, 5.0)
    held = (*axles, slide, rod, gear, rack)
    sensors = [jo.ReactionSensor(f"at {joint.name}", joint) for joint in held]
    return jo.Mechanism(
        *(*wheels, bar, weight, *held, push, *sensors),
        jo.CoordinateSensor("angle", axles[0].angle),
        jo.Gravity((0, 0, -9.81)),
    )


def test_gears_racks_and_rods() -> None:
    assert {name: d for name, d in compared(couplings(), 0.5).items() if not d < SAME} == {}


def rubbing() -> jo.Mechanism:
    """A pin, a bearing with collar and a guide that rub, on a moving base."""
    base = jo.RigidBody("base", 20.0, (2, 2, 2), velocity=(0, 1, 0))
    arm = jo.RigidBody(
        "arm",
        *(2.0, (0.1, 0.2, 0.3)),
        center=(0.4, 0.1, 0.2),
        velocity=(0, 1, 0),
        angular_velocity=(0, 1.2, 4),
    )
    sled = jo.RigidBody("sled", 3.0, (0.1, 0.1, 0.1), position=(1, 0, 0), velocity=(0.5, 0, 0.0))
    pin = jo.Revolute("pin", base["origin"], arm["origin"], axis=(0, 0.3, 1))
    guide = jo.Prismatic("guide", jo.ground["origin"], sled["origin"], axis=(1, 0, 0))
    frictions = (
        jo.Friction(
            "pin friction", pin, 0.2, 0.3, radius=0.05, bearing_length=0.1, collar_radius=0.06
        ),
        jo.Friction("guide friction", guide, 0.1, bearing_length=1.0, preload=4.0),
    )
    return jo.Mechanism(
        *(base, arm, sled, pin, guide, *frictions, jo.Gravity((0, 3, -9.81))),
        *(jo.ForceSensor(f.name, f) for f in frictions),
        jo.ReactionSensor("at pin", pin),
        jo.ReactionSensor("at guide", guide),
        jo.RateSensor("slip", guide.displacement),
        jo.RateSensor("turn", pin.angle),
    )


def test_friction_that_the_reactions_press() -> None:
    found = compared(rubbing(), 0.25)
    assert {name: d for name, d in found.items() if not d < SAME} == {}


def test_states_that_do_not_fit_show_their_gaps() -> None:
    machine = couplings()
    run = jo.simulate(jo.compile(machine), 0.01, solver=jo.RK4(1e-3))
    assert read(machine, run).gaps.max() < 1e-12
    state = run.state(0.0)
    q = state.q.copy()
    q[1] += 0.02  # the first wheel leaves its axle by 20 mm
    moved = jo.simulation.State(q, state.v, state.lam)
    found = at_states(machine, [moved], ())
    assert found.gaps.max() == pytest.approx(0.02 / machine.size, rel=1e-9)
    assert found.open_joints(1e-9) == ("axle 0",)


NODE = jo.reduction.NodeFrame("start")
BASES = {
    "polynomials": jo.reduction.ShapeFunctions(jo.reduction.Polynomials(3), frame=NODE),
    "Craig and Bampton": jo.CraigBampton(("start", "end"), modes=4, frame=NODE),
}


@pytest.mark.parametrize("basis", BASES)
def test_modes_in_the_frame_of_a_node(basis: str) -> None:
    """They leave its frame the inertia of the node alone: rounding must not grow with that.

    1e-7: the rounding of C'' times the penalty is in reactions, 1e-8 of the largest.
    """
    mechanism = with_added_sensors(rssr(BASES[basis]))
    model = jo.compile(mechanism)
    run = jo.simulate(model, 1e-3, solver=jo.RK4(2e-6), output_step=2.5e-4)
    sizes = typical_sizes(mechanism, 1e-3, largest_of(run))
    engine, found = by_engine(model, run, run.time), read(mechanism, run).readings
    for sensor in mechanism.sensors:
        size = max(np.abs(engine[sensor.name]).max(), 1e-3 * sizes[sensor.unit.split(",")[0]])
        np.testing.assert_allclose(
            found[sensor.name], engine[sensor.name], rtol=0, atol=1e-7 * size, err_msg=sensor.name
        )
