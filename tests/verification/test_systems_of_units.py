"""One machine described in other consistent units moves alike.

With lengths times L, times times T and masses times M every reading changes by its own dimension
and by nothing else (dimensional invariance of the laws of mechanics: Bridgman, Dimensional
Analysis, 1922). The factors are powers of two, by which floating-point numbers are scaled exactly:
explicit methods agree to the last bit. What is left elsewhere is the order of pivots and singular
vectors with other units, some roundings, which the motion amplifies. A threshold with a unit in it
shows at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo

Array = NDArray[np.float64]

ROUNDING = 1e-9
"""Of the largest value: 1e-11 is reached, and more where rounding excites what rests."""


@dataclass(frozen=True)
class Units:
    """Factors by which the numbers of lengths, times and masses are larger than in SI."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    def of(self, dimension: str) -> float:
        """Return the factor of a quantity, e.g. "m kg s-2"."""
        factor = 1.0
        for one in dimension.split():
            base = one.rstrip("-0123456789")
            exponent = int(one[len(base) :] or 1)
            factor *= {"m": self.length, "s": self.time, "kg": self.mass}[base] ** exponent
        return factor


SYSTEMS = {
    "micro": Units(2.0**-14, 1.0, 2.0**-42),  # 0.06 mm, with the masses of its material
    "mm-t-s": Units(2.0**10, 1.0, 2.0**-10),
    "10 km": Units(2.0**13, 1.0, 2.0**14),
    "fast": Units(2.0**-10, 2.0**-7, 2.0**-30),
    "slow": Units(1.0, 2.0**7, 1.0),
}
FORCE, MOMENT = "m kg s-2", "m2 kg s-2"


@cache
def rod(u: Units) -> jo.ReducedPart:
    """A bar of 1 m."""
    section = jo.Rectangle(0.03 * u.length, 0.02 * u.length)
    stuff = jo.Material(
        E=2e9 * u.of("kg m-1 s-2"), nu=0.3, rho=1000 * u.of("kg m-3"), name="of the rod"
    )
    part = jo.Part.beam(u.length, section, 4, stuff, name="rod")
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=1))


def slider_crank(u: Units, *, driven: bool = False, rubs: bool = True) -> list[Any]:
    """An elastic slider-crank with spring and friction beside a body in a bushing."""
    m, kg, J = u.length, u.mass, u.of("kg m2")
    force, moment = u.of(FORCE), u.of(MOMENT)

    def at(x: float, y: float, z: float) -> tuple[float, ...]:
        return (x * m, y * m, z * m)

    crank = jo.RigidBody(
        "crank",
        2.0 * kg,
        (0.01 * J, 0.02 * J, 0.02 * J),
        center=at(0.1, 0, 0),
        markers={"pin": at(0.2, 0, 0)},
        angular_velocity=(0.0, 0.0, 0.0 if driven else 3.0 / u.time),
    )
    bar = jo.FlexibleBody("rod", rod(u), position=at(0.2, 0, 0), damping=0.01)
    slider = jo.RigidBody("slider", 3.0 * kg, (0.01 * J,) * 3, position=at(1.2, 0, 0))
    block = jo.RigidBody(
        "block",
        kg,
        (0.02 * J, 0.03 * J, 0.01 * J),
        position=at(0, 1, 0),
        center=at(0, -0.2, 0.1),
    )
    turn = jo.Revolute("hinge", jo.ground["origin"], crank["origin"], axis=(0, 0, 1))
    guide = jo.Prismatic("guide", jo.ground["origin"], slider["origin"], axis=(1, 0, 0))
    bushing = jo.Bushing(
        "mount",
        jo.ground.at(at(0, 1, 0.1)),
        block.at(at(0, 0, 0.1)),
        (500 * force / m,) * 3 + (5 * moment,) * 3,
        (3 * force / m * u.time,) * 3 + (0.1 * moment * u.time,) * 3,
    )
    items = [
        *(crank, bar, slider, block, turn, guide, bushing),
        jo.Revolute("pin", crank["pin"], bar["start"], axis=(0, 0, 1)),
        jo.Spherical("wrist", bar["end"], slider["origin"]),
        jo.Spring(
            "spring", guide.displacement, 200 * force / m, 5 * force / m * u.time, free=0.3 * m
        ),
        jo.Gravity((0, -9.81 * u.of("m s-2"), 0)),
        jo.PositionSensor("x", slider["origin"]),
        jo.OrientationSensor("turn", block["origin"]),
        jo.StressSensor("stress", bar, "e2.a.top"),
        jo.ReactionSensor("bearing", turn),
        jo.AccelerationSensor("a", slider["origin"]),
    ]
    if rubs:
        law = jo.mechanism.Regularised(velocity=0.05 * u.of("m s-1"))
        items.append(jo.Friction("rub", guide, 0.2, law=law))
    if driven:
        items.append(
            jo.Drive("motor", turn.angle, jo.Harmonic(amplitude=0.7, frequency=0.5 / u.time))
        )
    return items


def scaled(run: jo.Solution, u: Units, rows: slice = slice(None)) -> dict[str, Array]:
    """Return the readings in SI over what they come to."""
    bearing = np.array([u.of(FORCE)] * 3 + [u.of(MOMENT)] * 3)
    units: dict[str, Any] = {
        "x": u.length,
        "turn": 1.0,
        "stress": u.of("kg m-1 s-2"),
        "bearing": bearing,
        "a": u.of("m s-2"),
    }
    come_to = {"x": 1.0, "turn": 1.0, "stress": 1e6, "bearing": 30.0, "a": 10.0}
    return {name: run[name][rows] / units[name] / come_to[name] for name in units}


def agree(found: dict[str, Array], wanted: dict[str, Array]) -> None:
    """Compare readings, name by name."""
    off = {name: float(np.abs(found[name] - x).max()) for name, x in wanted.items()}
    beyond = {n: x for n, x in off.items() if x > ROUNDING * max(1.0, np.abs(wanted[n]).max())}
    assert not beyond


def in_motion(solver: Callable[[float], Any], **kind: Any) -> Callable[[Units], dict[str, Array]]:
    """Return what runs half a second with a solver made for a unit of time."""

    def readings(u: Units) -> dict[str, Array]:
        model = jo.compile(jo.Mechanism(*slider_crank(u, **kind)))
        run = jo.simulate(model, 0.5 * u.time, solver=solver(u.time), output_step=0.05 * u.time)
        return scaled(run, u)

    return readings


def standing(find: Callable[[jo.Model], Any], **kind: Any) -> Callable[[Units], dict[str, Array]]:
    """Return what reads all sensors in a state that is found."""

    def readings(u: Units) -> dict[str, Array]:
        model = jo.compile(jo.Mechanism(*slider_crank(u, rubs=False, **kind)))
        step = 1e-4 * u.time
        run = jo.simulate(model, step, state=find(model), solver=jo.RK4(step))
        return scaled(run, u, slice(0, 1))

    return readings


def frequencies(u: Units) -> dict[str, Array]:
    """Natural frequencies at rest, over their own."""
    model = jo.compile(jo.Mechanism(*slider_crank(u, rubs=False)))
    found = jo.modes(model, jo.equilibrium(model)).frequencies * u.time
    own = np.array([1.0, *([10.0] * 3)] + [100.0] * 40)[: len(found)]
    return {"f": found / np.maximum(own, 1.0)}


def four_bars(u: Units, **options: Any) -> jo.Model:
    """A four-bar linkage in space, three rows of which repeat others."""
    corners = np.array([(0, 0, 0), (0, 0.3, 0), (0.8, 0.6, 0), (0.9, 0, 0)]) * u.length
    bars = [
        jo.RigidBody(
            f"bar {i}",
            (1 + i) * u.mass,
            tuple(np.array([0.01, 0.02, 0.03]) * u.of("kg m2")),
            position=corners[i],
            center=0.5 * (corners[i + 1] - corners[i]),
            markers={"end": corners[i + 1] - corners[i]},
        )
        for i in range(3)
    ]
    sides = [jo.ground["origin"]]
    for bar in bars:
        sides += [bar["origin"], bar["end"]]
    sides.append(jo.ground.at(corners[3]))
    hinges = [
        jo.Revolute(f"hinge {i}", sides[2 * i], sides[2 * i + 1], axis=(0, 0, 1)) for i in range(4)
    ]
    items: list[Any] = [jo.Gravity((0, -9.81 * u.of("m s-2"), 0))]
    items.append(jo.PositionSensor("end", bars[1]["end"]))
    if options.pop("driven", False):
        swing = jo.Harmonic(amplitude=0.5, frequency=0.5 / u.time)
        items.append(jo.Drive("motor", hinges[0].angle, swing))
    if options.pop("placed", False):
        items.append(jo.Initial(hinges[0].angle, value=0.4, rate=2.0 / u.time))
    return jo.compile(jo.Mechanism(*bars, *hinges, *items, **options))


def swinging(solver: Callable[[float], Any], **options: Any) -> Callable[[Units], dict[str, Array]]:
    """Return what lets the four-bar linkage swing for a second."""

    def readings(u: Units) -> dict[str, Array]:
        model = four_bars(u, **options)
        run = jo.simulate(model, u.time, solver=solver(u.time), output_step=0.1 * u.time)
        return {"end": run["end"] / u.length}

    return readings


def prescribed(u: Units) -> dict[str, Array]:
    """Positions of the driven linkage, without integration."""
    run = jo.simulation.kinematics(four_bars(u, driven=True), np.linspace(0, 2, 11) * u.time)
    return {"end": run["end"] / u.length}


def blade(u: Units) -> dict[str, Array]:
    """A rod on a hub that turns steadily."""
    hub = jo.RigidBody(
        "hub", u.mass, (0.01 * u.of("kg m2"),) * 3, markers={"rim": (0.1 * u.length, 0, 0)}
    )
    bar = jo.FlexibleBody("rod", rod(u), position=(0.1 * u.length, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            hub,
            bar,
            jo.Revolute("axle", jo.ground["origin"], hub["origin"], axis=(0, 0, 1)),
            jo.Fixed("root", hub["rim"], bar["start"]),
            jo.PositionSensor("tip", bar["end"]),
        )
    )
    found = jo.simulation.steady_rotation(model, (0, 0, 1), 20.0 / u.time)
    step = 1e-3 * u.time
    run = jo.simulate(model, step, state=found, solver=jo.ROS2(step))
    return {"tip": run["tip"] / u.length}


def exact_beam(u: Units) -> dict[str, Array]:
    """A beam that falls into its sag."""
    stuff = jo.Material(E=1e8 * u.of("kg m-1 s-2"), nu=0.3, rho=1000 * u.of("kg m-3"), name="soft")
    ends = [(0.0, 0.0, 0.0), (u.length, 0.2 * u.length, 0.0)]
    beam = jo.BeamBody("beam", ends, jo.Circle(0.02 * u.length), stuff, elements=4)
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed("root", jo.ground["origin"], beam["start"]),
            jo.Gravity((0, -9.81 * u.of("m s-2"), 0)),
            jo.PositionSensor("tip", beam["end"]),
        )
    )
    step = 1e-3 * u.time
    falls = jo.simulate(model, 100 * step, solver=jo.GeneralizedAlpha(step))
    rests = jo.simulate(model, step, state=jo.equilibrium(model), solver=jo.GeneralizedAlpha(step))
    return {"falls": falls["tip"] / u.length, "rests": rests["tip"] / u.length}


CASES: dict[str, Callable[[Units], dict[str, Array]]] = {
    "RK4": in_motion(lambda s: jo.RK4(2e-4 * s)),
    "ROS2": in_motion(lambda s: jo.ROS2(5e-4 * s)),
    "generalised alpha": in_motion(lambda s: jo.GeneralizedAlpha(1e-3 * s)),
    "exact tangent": in_motion(lambda s: jo.GeneralizedAlpha(1e-3 * s, tangent="exact")),
    "Newmark": in_motion(lambda s: jo.simulation.Newmark(1e-3 * s)),
    "DormandPrince": in_motion(lambda s: jo.simulation.DormandPrince(1e-8)),
    "driven": in_motion(lambda s: jo.ROS2(5e-4 * s), driven=True),
    "equilibrium": standing(jo.equilibrium),
    "vibration-free": standing(jo.simulation.vibration_free_state),
    "driven vibration-free": standing(jo.simulation.vibration_free_state, driven=True),
    "modes": frequencies,
    "repeated rows": swinging(lambda s: jo.ROS2(1e-3 * s), core="maximal"),
    "repeated rows in joint coordinates": swinging(lambda s: jo.ROS2(1e-3 * s), core="joint"),
    "repeated rows, implicit": swinging(lambda s: jo.GeneralizedAlpha(1e-3 * s)),
    "given start": swinging(lambda s: jo.RK4(1e-3 * s), placed=True),
    "kinematics": prescribed,
    "steady rotation": blade,
    "exact beam": exact_beam,
}
IN_SI: dict[str, dict[str, Array]] = {}


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")  # of materials that exist nowhere
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("case", CASES)
def test_a_machine_in_other_units_moves_alike(case: str, system: str) -> None:
    if case not in IN_SI:
        IN_SI[case] = CASES[case](Units())
    agree(CASES[case](SYSTEMS[system]), IN_SI[case])


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("system", [name for name, u in SYSTEMS.items() if u.time == 1.0])
def test_the_default_method_treats_lengths_and_masses_alike(system: str) -> None:
    """Its step of 1 ms is a time by declaration: that unit stays."""
    default = in_motion(lambda s: None)
    agree(default(SYSTEMS[system]), default(Units()))
    linkage = swinging(lambda s: None)
    agree(linkage(SYSTEMS[system]), linkage(Units()))
