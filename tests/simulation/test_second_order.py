"""Bodies reduced without stiffening: what asks for their second order has it, or says it has not.

Closed forms: Euler's columns, a string-beam under tension (``f sqrt(1 + N/N_cr)`` of a hinged beam,
Timoshenko, *Vibration Problems in Engineering*), an amplified deflection ``1/(1 - N/N_cr)``.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import jousto as jo
from jousto.simulation import second_order
from jousto.simulation.check_bending import FAR
from jousto.simulation.state import State
from parts.grids import grid
from verification.test_rotating_beam import FLAP, SECTION, STEEL as BLADE, UNIT

X, Z = (1, 0, 0), (0, 0, 1)
STEEL = jo.Material(E=210e9, nu=0.0, rho=7850.0)
CALM = pytest.mark.filterwarnings("ignore:.*static work", "ignore:.*has no joint to another")


def euler(side: float, length: float) -> float:
    """Critical load of a column on two hinges, N."""
    return np.pi**2 * STEEL.E * side**4 / 12.0 / length**2


@cache
def beam(side: float, length: float, stiffening: bool = False) -> jo.ReducedPart:
    part = jo.Part.beam(
        length, jo.Rectangle(side, side), 12, STEEL, theory=jo.parts.EulerBernoulli()
    )
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6), stiffening=stiffening)


@cache
def solid(side: float, length: float) -> jo.ReducedPart:
    """The same of solids, both ends tied rigidly to a node."""
    mesh = grid(
        "hexahedron20", (20, 1, 1), (length, side, side), bend=lambda x: x - [0, side / 2, side / 2]
    )
    ends = {"start": mesh.nodes[:, 0] < 1e-9, "end": mesh.nodes[:, 0] > length - 1e-9}
    ties = [jo.Interface(name, np.flatnonzero(where)) for name, where in ends.items()]
    part = jo.Part.solid(mesh, STEEL, interfaces=ties)
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))


def hinged(part: jo.ReducedPart, length: float, push: float = 0.0, side: float = 0.0) -> jo.Model:
    """A column on two hinges; an input "load" presses it, a force pushes its middle sideways."""
    bar = jo.FlexibleBody("bar", part)
    head = jo.RigidBody("head", 1e-3, (1e-6,) * 3, position=(length, 0, 0))
    items = [
        *(bar, head),
        jo.Revolute("foot", jo.ground["origin"], bar["start"], axis=Z),
        jo.Prismatic("guide", jo.ground.at((length, 0, 0)), head["origin"], axis=X),
        jo.Revolute("top", head["origin"], bar["end"], axis=Z),
        jo.Force("press", head["origin"], (-1, 0, 0), signal=jo.Input("load", initial=push)),
    ]
    if side:
        items.append(jo.Force("side", bar["node7"], (0, side, 0)))
    return jo.compile(jo.Mechanism(*items))


def clamped(part: jo.ReducedPart) -> jo.Model:
    """A column that is free at its end."""
    bar = jo.FlexibleBody("bar", part)
    foot = jo.Fixed("foot", jo.ground["origin"], bar["start"])
    push = jo.Force("press", bar["end"], (-1, 0, 0), signal=jo.Input("load"))
    return jo.compile(jo.Mechanism(bar, foot, push))


# 12 cubic elements and 6 modes meet Euler's load to 1e-5; solids of 20 elements to 2e-3
@pytest.mark.parametrize(
    ("part", "side", "length", "tolerance"),
    [(beam, 0.1, 3.0, 1e-4), (beam, 0.01, 1.0, 1e-4), (solid, 0.01, 1.0, 2e-3)],
)
@pytest.mark.parametrize("method", ["linear", "path"])
def test_a_linear_column_buckles_at_eulers_load(part, side, length, tolerance, method) -> None:
    load = euler(side, length)
    found = jo.simulation.buckling(
        hinged(part(side, length), length), "load", 1, method=method, to=1.2 * load
    )
    assert found.loads[0] == pytest.approx(load, rel=tolerance)


@pytest.mark.parametrize("frame", [None, "node", "chord"])
def test_a_free_end_buckles_at_a_quarter_of_it_in_any_frame(frame: str | None) -> None:
    part = beam(0.1, 3.0)
    if frame == "node":
        part = jo.reduction.in_frame(part, jo.reduction.NodeFrame("start"))
    elif frame == "chord":
        part = jo.reduction.in_frame(part, jo.reduction.ChordFrame("start", "end"))
    found = jo.simulation.buckling(clamped(part), "load", 1)
    assert found.loads[0] == pytest.approx(0.25 * euler(0.1, 3.0), rel=1e-4)


@pytest.mark.parametrize("dear", [False, True])
@pytest.mark.parametrize("part", [beam, solid])
def test_tension_raises_the_frequency_of_a_linear_rod(part, dear: bool, monkeypatch) -> None:
    if dear:  # so large that it is asked first whether the loads count
        monkeypatch.setattr(second_order, "CHEAP", 0)
    model = hinged(part(0.01, 1.0), 1.0, push=-5e3)
    I_A = 0.01**2 / 12.0
    free = np.pi / 2.0 * np.sqrt(STEEL.E * I_A / STEEL.rho)  # 23.45 Hz
    wanted = free * np.sqrt(1.0 + 5e3 / euler(0.01, 1.0))  # 46.29 Hz
    found = jo.modes(model, jo.equilibrium(model)).frequencies
    # the rod is 1 / 8500 longer under the load, solids are 1e-3 too soft in bending
    assert np.abs(found / wanted - 1.0).min() < 2e-3


def test_an_unloaded_large_part_is_left_alone(monkeypatch) -> None:
    monkeypatch.setattr(second_order, "CHEAP", 0)
    model = hinged(beam(0.01, 1.0), 1.0)
    assert second_order.where_noticed(model, None, "modes") is model


@CALM
def test_a_spinning_linear_blade_has_published_frequencies() -> None:
    part = jo.Part.beam(1.0, SECTION, 8, BLADE, theory=jo.parts.EulerBernoulli())
    rod = jo.FlexibleBody("blade", jo.reduce(part, jo.CraigBampton(("start",), modes=12)))
    hub = jo.RigidBody("hub", 1e6, 1e6 * np.eye(3))
    model = jo.compile(
        jo.Mechanism(
            *(hub, rod, jo.Fixed("root", hub["origin"], rod["start"])),
            jo.Revolute("axle", jo.ground["origin"], hub["origin"], axis=Z),
        )
    )
    state = jo.simulation.steady_rotation(model, Z, 12.0 * UNIT)
    found = jo.modes(model, state, damped=True).frequencies * 2.0 * np.pi / UNIT
    for wanted in FLAP[12.0]:
        assert np.abs(found / wanted - 1.0).min() < 5e-4  # as with stiffening=True


def without_mesh() -> jo.ReducedPart:
    return replace(beam(0.01, 1.0), source=None)


def of_matrices() -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Rectangle(0.01, 0.01), 12, STEEL)
    return jo.reduce(replace(part, second_order=None), jo.CraigBampton(("start", "end"), modes=2))


@pytest.mark.parametrize("part", [without_mesh, of_matrices])
@pytest.mark.parametrize("verb", ["buckling", "load_path"])
def test_a_part_without_its_stress_is_refused_by_name(part, verb: str) -> None:
    model = hinged(part(), 1.0)
    more = {"to": 1.0} if verb == "load_path" else {}
    with pytest.raises(
        jo.InputError, match=f"{verb}: body 'bar'.*its part .*(stiffening=True|solids)"
    ):
        getattr(jo.simulation, verb)(model, "load", **more)


def test_modes_warn_of_what_they_cannot_count() -> None:
    model = hinged(without_mesh(), 1.0, push=-5e3)
    with pytest.warns(jo.JoustoWarning, match="body 'bar' is linear.*about 2.9e\\+02 %"):
        state = jo.equilibrium(model)  # 5000 N / 1727 N
    with pytest.warns(jo.JoustoWarning, match="body 'bar' is linear"):
        jo.modes(model, state)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.modes(hinged(without_mesh(), 1.0, push=1.0))


def test_the_estimate_is_the_load_over_the_critical_one() -> None:
    part, load = beam(0.01, 1.0), euler(0.01, 1.0)
    for model, share in ((hinged(part, 1.0, push=0.1 * load), 0.1), (clamped(part), 0.1)):
        state = jo.equilibrium(model, replace(start(model), inputs={"load": 0.1 * load}))
        found = second_order.stiffness_shares(model, state, {0})[0]
        assert found == pytest.approx(share, rel=0.02)  # of the free body: as on two hinges


def start(model: jo.Model) -> State:
    return State(model.q0, model.v0, np.zeros(model.nrow))


def test_equilibrium_beyond_the_critical_load_is_refused() -> None:
    load = euler(0.01, 1.0)
    jo.equilibrium(hinged(beam(0.01, 1.0), 1.0, push=0.99 * load))
    model = hinged(beam(0.01, 1.0), 1.0, push=1.01 * load)
    with pytest.raises(jo.SimulationError, match="buckles.*'bar'.*stiffening=True"):
        jo.equilibrium(model)


@pytest.mark.filterwarnings("ignore:.*static work")
def test_equilibrium_warns_of_the_amplified_bending() -> None:
    load = euler(0.01, 1.0)
    model = hinged(beam(0.01, 1.0), 1.0, push=0.5 * load, side=5.0)
    with pytest.warns(jo.JoustoWarning, match="body 'bar'.* deflection by about") as said:
        jo.equilibrium(model)
    told = float(str(said[0].message).split("about ")[1].split(" %")[0])
    assert told == pytest.approx(100.0, abs=5.0)  # 1 / (1 - 0.5), but for the axial strain
    stiff = hinged(beam(0.01, 1.0, True), 1.0, push=0.5 * load, side=5.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.equilibrium(stiff)


def test_a_run_that_bends_far_is_told() -> None:
    """A strip of 1 m x 20 x 2 mm under 8 N: -0.653 m for -0.591 m of the elastica."""
    section = jo.Rectangle(0.02, 0.002)
    part = jo.Part.beam(1.0, section, 20, STEEL, theory=jo.parts.EulerBernoulli())
    strip = jo.FlexibleBody(
        "strip", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)), damping=0.5
    )

    def run(force: float) -> None:
        pull = jo.Force("pull", strip["end"], (0, 0, -force))
        weld = jo.Fixed("weld", jo.ground["origin"], strip["start"])
        jo.simulate(jo.compile(jo.Mechanism(strip, weld, pull)), 0.6, output_step=0.01)

    with pytest.warns(
        jo.JoustoWarning, match="simulate 'mechanism': body 'strip' bends by .* rad"
    ) as said:
        run(8.0)
    told = float(str(said[0].message).split("bends by ")[1].split(" rad")[0])
    assert told > FAR
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(1.0)


@CALM
def test_a_body_that_hardly_deforms_is_left_alone() -> None:
    """A hanging bar is stretched by some nanometres; nothing of that is second order."""
    bar = jo.FlexibleBody("bar", beam(0.01, 1.0))
    pin = jo.Revolute("pin", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    model = jo.compile(jo.Mechanism(bar, pin, jo.Gravity((0, 0, -9.81))))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.equilibrium(model)
