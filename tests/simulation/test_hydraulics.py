"""Hydraulic networks: closed forms, and digits on which independent integrations agree.

The digits of machines are those on which DOP853 and Radau of scipy agree for the equations of each
machine, written out by hand in minimal coordinates with kinks located; some are integrated here.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

import jousto as jo
from jousto.hydraulics import (
    Accumulator,
    CounterbalanceValve,
    Cushion,
    DirectionalValve,
    FlowSource,
    Hose,
    HydraulicCylinder,
    HydraulicNetwork,
    Leak,
    Node,
    Oil,
    Orifice,
    Pump,
    ReliefValve,
    Supply,
    Tank,
)
from jousto.mechanism import StateSensor, time, where

CORES = ("joint", "maximal")
LPM = 1e-3 / 60  # m3/s of 1 l/min
KV = 40 * LPM / math.sqrt(3.5e6)
STIFF = Oil(modulus=1.2e9)
REV = 2 * math.pi


def alone(network: HydraulicNetwork, *watched: str, core: str = "auto") -> jo.Mechanism:
    """A network beside a body that nothing moves."""
    body = jo.RigidBody("body", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"])
    sensors = [StateSensor(name, network[name]) for name in watched]
    hold = jo.Spring("hold", rail.displacement, 1.0)
    return jo.Mechanism(body, rail, hold, network, *sensors, core=core)


def run_alone(
    network: HydraulicNetwork, t: float, *watched: str, step: float = 1e-4, output: float = 0.0
) -> Any:
    model = jo.compile(alone(network, *watched))
    return jo.simulate(model, t, solver=jo.RK4(step), output_step=output or t)


def test_h1_modulus_of_oil_with_air() -> None:
    oil = Oil(modulus=1.5e9, air=0.01, polytropic=1.4)
    for absolute, expected in (
        (1e5, 13871824.3431),
        (1e6, 486265539.416),
        (1e7, 1442009860.94),
    ):
        assert oil.effective_modulus(absolute - 1e5) == pytest.approx(expected, rel=1e-11)
        # compression by a flow: p' = K_e Q/V at the pressure where it starts
        network = HydraulicNetwork(
            "oil",
            [Node("n", 1e-3, start=absolute - 1e5), Tank("tank"), FlowSource("in", "n", 1e-9),
             Leak("out", "n", "tank", 0.0)],
            oil=oil,
        )  # fmt: skip
        run = run_alone(network, 1e-3, "n")
        slope = (run["n"][-1, 0] - run["n"][0, 0]) / 1e-3
        assert slope == pytest.approx(1e-9 / 1e-3 * expected, rel=1e-5)
    model = jo.compile(alone(network, "n"))
    assert model.name
    w = 0.99 * math.exp(-(1e7 - 1e5) / 1.5e9) + 0.01 * (1e5 / 1e7) ** (1 / 1.4)
    assert w == pytest.approx(0.983860274213, rel=1e-11)


def edge_flow(p: float) -> float:
    network = HydraulicNetwork(
        "oil",
        [Supply("high", p), Tank("tank"), Node("n", 1e-3), Orifice("e", "high", "n", flow=40 * LPM),
         Orifice("f", "high", "tank", flow=40 * LPM)],
    )  # fmt: skip
    return float(run_alone(network, 1e-4, "f_flow")["f_flow"][0, 0])


def test_h2_edge() -> None:
    assert edge_flow(1e4) == pytest.approx(2.99652027014e-5, rel=1e-11)
    assert edge_flow(1e-3) / 1e-3 == pytest.approx(3.5634832255e-9, rel=1e-10)
    slope = (edge_flow(1e6 + 1e2) - edge_flow(1e6 - 1e2)) / 2e2
    assert slope == pytest.approx(1.78187522388e-10, rel=1e-7)


@pytest.mark.parametrize("volume", [1e-9, 1e-4])
def test_h2_two_edges_in_series_at_rest(volume: float) -> None:
    """The pressure between them does not depend on the volume, however small."""
    network = HydraulicNetwork(
        "oil",
        [
            Supply("high", 16e6),
            Node("between", volume, start=1e6),
            Tank("tank"),
            Orifice("one", "high", "between", flow=40 * LPM),
            Orifice("two", "between", "tank", flow=40 * LPM, opening=0.5),
        ],
        oil=STIFF,
    )
    model = jo.compile(alone(network, "between"))
    rest = jo.simulate(model, 1e-6, state=jo.equilibrium(model), solver=jo.ROS2(1e-6))
    assert rest["between"][0, 0] == pytest.approx(12799988.2814, abs=1e-4)


def deadhead() -> HydraulicNetwork:
    return HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Node("line", 1e-3),
            Pump("pump", "tank", "line", 16e-6 / REV, speed=25 * REV, leak=1e-12),
            ReliefValve("relief", "line", "tank", setting=20e6, full=1e6, flow=40 * LPM, drop=1e6),
        ],
        oil=Oil(modulus=1.5e9),
    )


def test_h3_pump_against_a_relief_valve() -> None:
    network = deadhead()
    run = run_alone(network, 0.0341955295917, "line", step=1e-4)
    assert run["line"][-1, 0] == pytest.approx(20e6, abs=1e-2)
    run = run_alone(network, 0.2, "line", "relief_heat", step=5e-5)
    assert run["line"][-1, 0] == pytest.approx(20222682.4697, abs=1e-3)
    # at rest all of the pump's flow, less its leak, becomes heat in the valve
    assert run["relief_heat"][-1, 0] == pytest.approx(
        20222682.4697 * (4e-4 - 1e-12 * 20222682.4697), rel=1e-10
    )
    model = jo.compile(alone(network, "line", "heat_power"))
    rest = jo.simulate(model, 1e-6, state=jo.equilibrium(model), solver=jo.ROS2(1e-6))
    assert rest["line"][0, 0] == pytest.approx(20222682.4697, abs=1e-3)
    assert rest["heat_power"][0, 0] == pytest.approx(20222682.4697 * 4e-4, rel=1e-9)


def relieved(full: float, lag: float | None = None) -> Any:
    """A pump raises the pressure by K Q h/V = 0.6 MPa in 1 ms, up to a valve open in `full`."""
    valve = {"setting": 20e6, "full": full, "lag": lag, "flow": 40 * LPM, "drop": 1e6}
    line = HydraulicNetwork(
        "oil",
        [
            *(Tank("tank"), Node("line", 1e-3)),
            Pump("pump", "tank", "line", 16e-6 / REV, speed=25 * REV),
            ReliefValve("relief", "line", "tank", **valve),
        ],
        oil=Oil(modulus=1.5e9),
    )
    return jo.compile(alone(line, "line"))


def test_valves_that_open_within_a_step_are_named(recwarn: pytest.WarningsRecorder) -> None:
    narrow = relieved(1e5)
    warned = r"relief valve 'relief' \(full\) of hydraulics 'oil' by 100 % at 0.034 s"
    with pytest.warns(jo.JoustoWarning, match=warned) as found:
        run = jo.simulate(narrow, 0.04, solver=jo.ROS2(1e-3))
    assert "take steps of 0.00025 s" in str(found[0].message)
    (again,) = jo.doctor(run).warnings
    assert again in str(found[0].message)
    recwarn.clear()
    run = jo.simulate(narrow, 0.03, solver=jo.ROS2(1e-3))  # still closed; the last run is past
    assert not jo.doctor(run).warnings
    jo.simulate(narrow, 0.04, solver=jo.ROS2(5e-5))  # 0.03 MPa in a step
    jo.simulate(relieved(2e6), 0.04, solver=jo.ROS2(1e-3))
    jo.simulate(relieved(1e5, lag=0.01), 0.04, solver=jo.ROS2(1e-3))  # opens by its lag
    assert not recwarn.list


@pytest.mark.parametrize("method", [jo.GeneralizedAlpha, jo.simulation.Newmark])
@pytest.mark.parametrize("full", [1e4, 1e5])
def test_implicit_methods_follow_a_valve_that_opens_within_a_step(method: Any, full: float) -> None:
    """From the closed valve Newton's method leads to a valve open wide, and back: it is damped."""
    model = relieved(full)
    fine = jo.simulate(model, 0.06, solver=jo.RK4(2e-6), output_step=1e-3)["line"]
    run = jo.simulate(model, 0.06, solver=method(1e-3), output_step=1e-3)["line"]
    assert np.abs(run - fine).max() < 5e3  # Pa, of 20 MPa


def test_h4_accumulator_is_charged() -> None:
    """From 9 MPa, the precharge, through an edge by 20 MPa, by the law of the gas alone.

    Its end at the precharge is smooth over 9 kPa: the run starts 18 kPa above it, and the time from
    the precharge to there is that of the integral.
    """

    def flow(p: float) -> float:
        return float(1e-7 * (20e6 - p) / ((20e6 - p) ** 2 + 1e8) ** 0.25)

    def compliance(p: float) -> float:
        return float(10e-3 / (1.4 * p) * (9e6 / p) ** (1 / 1.4))

    first = 1.002 * 9e6
    begun = quad(lambda p: compliance(p) / flow(p), 9e6, first, epsrel=1e-12)[0]
    network = HydraulicNetwork(
        "oil",
        [
            *(Supply("high", 20e6 - 1e5), Tank("tank"), Node("n", 1e-12, start=first - 1e5)),
            Accumulator("gas", "n", 10e-3, 9e6 - 1e5, polytropic=1.4),
            Orifice("in", "high", "n", flow=1e-4, drop=1e6),
            Leak("out", "n", "tank", 0.0),
        ],
        oil=STIFF,
        book=True,
    )
    model = jo.compile(alone(network, "n", "gas_oil", "stored_work"))
    t = 10.7088989806 - begun
    run = jo.simulate(model, t, solver=jo.simulation.DormandPrince(1e-9), output_step=t)
    assert run["n"][-1, 0] + 1e5 == pytest.approx(15e6, rel=1e-11)
    assert run["gas_oil"][-1, 0] == pytest.approx(3.05716878453e-3, rel=1e-11)
    assert flow(15e6) / compliance(15e6) == pytest.approx(flow(15e6) / 3.30611010261e-10, rel=1e-11)
    # from the precharge on, and the atmosphere takes part of the work of the gas
    early = 9e6 * 10e-3 / 0.4 * (1.002 ** (0.4 / 1.4) - 1) - 1e5 * run["gas_oil"][0, 0]
    work = 35356.1705801 - 1e5 * 3.05716878453e-3
    assert run["stored_work"][-1, 0] + early == pytest.approx(work, rel=1e-9)


def cushioned(core: str) -> jo.Mechanism:
    body = jo.RigidBody("mass", 500.0, (1, 1, 1), position=(0.85, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    network = HydraulicNetwork(
        "oil",
        [
            Supply("high", 2e6),
            Tank("tank"),
            HydraulicCylinder(
                "c", jo.ground["origin"], body["origin"], "high", "tank",
                bore=0.063, rod=0.036, stroke=0.4, closed=0.5, damping=2000.0,
                rod_cushion=Cushion(length=0.03, flow=80 * LPM, least=0.01, start=1e6),
            ),
        ],
        oil=STIFF,
    )  # fmt: skip
    start = jo.Initial(rail.displacement, rate=0.5)
    return jo.Mechanism(
        body, rail, network, start, StateSensor("x", network["c_x"]),
        jo.RateSensor("v", rail.displacement), StateSensor("p2", network["c_rod"]), core=core,
    )  # fmt: skip


@pytest.mark.parametrize("core", CORES)
def test_h5_cushion(core: str) -> None:
    model = jo.compile(cushioned(core))
    run = jo.simulate(model, 0.0385827550508, solver=jo.RK4(1e-5))
    assert run["x"][-1, 0] == pytest.approx(0.37, abs=1e-12)
    assert run["v"][-1, 0] == pytest.approx(0.527197213136, abs=1e-9)
    run = jo.simulate(model, 0.513574288444, solver=jo.RK4(1e-5))
    assert run["p2"].max() == pytest.approx(5851563.04442, abs=0.01)
    assert run["x"][-1, 0] == pytest.approx(0.4, abs=1e-11)


A63, R63 = math.pi * 0.063**2 / 4, math.pi * (0.063**2 - 0.036**2) / 4


def lowering(core: str, ratio: float, flow: Any, p1: float, p2: float, v: float) -> jo.Mechanism:
    """A load of 20 kN that a flow into the rod side lowers through a counterbalance valve."""
    body = jo.RigidBody("load", 2000.0, (1, 1, 1), position=(0.8, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ends = jo.ground["origin"], body["origin"]
    size = {"bore": 0.063, "rod": 0.036, "stroke": 0.4, "closed": 0.5}
    valve = {"setting": 9e6, "full": 2e6, "ratio": ratio, "flow": 60 * LPM, "drop": 3e6}
    network = HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Node("A", start=p1),
            Node("B", start=p2),
            FlowSource("pump", "B", flow),
            HydraulicCylinder("c", *ends, "A", "B", damping=2e4, **size),
            CounterbalanceValve("hold", "A", "tank", "B", **valve),
        ],
        oil=STIFF,
    )
    others = (
        jo.Force("weight", body["origin"], (-20e3, 0, 0)),
        jo.Initial(rail.displacement, rate=v),
        *(StateSensor(name, network[name]) for name in ("A", "B", "c_x")),
        jo.RateSensor("v", rail.displacement),
    )
    return jo.Mechanism(body, rail, network, *others, core=core)


@pytest.mark.parametrize("core", CORES)
def test_h6_counterbalance_valve(core: str) -> None:
    flow = jo.Ramp(0, 0.2) * (20 * LPM)
    model = jo.compile(lowering(core, 0.5, flow, (20e3 + R63 * 2e6) / A63, 2e6, 0.0))
    run = jo.simulate(model, 0.4, solver=jo.RK4(1e-4), output_step=0.1)
    assert run["c_x"][2, 0] == pytest.approx(0.284399962506, abs=1e-12)
    assert run["A"][2, 0] == pytest.approx(7636506.01739, abs=1e-3)
    assert -run["v"][-1, 0] == pytest.approx(0.157901760348, abs=1e-10)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(
    ("ratio", "p1", "p2", "pole"),
    [
        (0.5, 7886207.76788, 3695777.17011, -4.80296875387 + 121.111535702j),
        (1.51948434167, None, None, 0.0),
        (3.0, 6202407.77669, None, 6.99474704743),
    ],
)
def test_h6_poles_at_full_flow(core: str, ratio: float, p1: Any, p2: Any, pole: complex) -> None:
    """Stable with the pilot ratio 0.5, at its limit with 1.519, unstable with 3."""
    speed = 20 * LPM / R63
    assert speed == pytest.approx(0.158777845708, rel=1e-11)

    def behind(p: float) -> float:
        return float((A63 * p - 20e3 + 2e4 * speed) / R63)

    def flow(p: float) -> float:
        z = min(max((p + ratio * behind(p) - 9e6) / 2e6, 0.0), 1.0)
        kv = 60 * LPM / math.sqrt(3e6)
        return float(z * z * (3 - 2 * z) * kv * p / (p * p + 1e8) ** 0.25 - A63 * speed)

    found = brentq(flow, 5e6, 9e6, xtol=1e-7)
    assert p1 is None or found == pytest.approx(p1, rel=1e-11)
    assert p2 is None or behind(found) == pytest.approx(p2, rel=1e-11)
    made = lowering(core, ratio, 20 * LPM, found, behind(found), -speed)
    A = np.array(jo.simulation.linearise(jo.compile(made)).A)
    poles = np.linalg.eigvals(A[1:, 1:])  # without x, as in the source
    swing = poles[poles.imag > 1.0]
    assert np.abs(swing.real - np.real(pole)).min() < 1e-8
    assert not np.imag(pole) or np.abs(swing - pole).min() < 1e-8


def test_h7_spool() -> None:
    valve = DirectionalValve(
        *("v", "P", "T", "A", "B"),
        flow=40 * LPM,
        command=1.0,
        frequency=60.0,
        damping=0.9,
        rate_limit=20.0,
    )
    places = [Supply("P", 10e6), Tank("T"), Node("A", 1e-3), Node("B", 1e-3)]
    model = jo.compile(alone(HydraulicNetwork("oil", [*places, valve]), "v_spool"))
    run = jo.simulate(model, 0.0450727344738, solver=jo.RK4(1e-6))
    assert run["v_spool"][-1, 0] == pytest.approx(0.9, abs=2e-8)


def test_h8_oil_spring() -> None:
    body = jo.RigidBody("mass", 200.0, (1, 1, 1), position=(0.75, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ends, size = (jo.ground["origin"], body["origin"]), {"bore": 0.05, "rod": 0.036}
    for oil, hose, expected in (
        (Oil(modulus=1.5e9), 0.0, 262.433734087),
        (Oil(modulus=1.5e9, air=0.005), 0.0, 253.179736291),
        (Oil(modulus=1.5e9, air=0.005), 1e-13, 223.628557816),
    ):
        network = HydraulicNetwork(
            "oil",
            [
                Tank("tank"),
                Node("A", start=4.9e6, compliance=hose),
                Node("B", start=3.9e6, compliance=hose),
                *(Leak(f"leak{x}", x, "tank", 0.0) for x in "AB"),
                HydraulicCylinder("c", *ends, "A", "B", stroke=0.5, closed=0.5, **size),
            ],
            oil=oil,
        )
        model = jo.compile(jo.Mechanism(body, rail, network))
        poles = np.linalg.eigvals(jo.simulation.linearise(model).A)
        assert np.abs(poles).max() == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("cells", "expected"), [(1, 30.7005315676), (8, None)])
def test_h8_hose(cells: int, expected: float | None) -> None:
    """First frequency of the cells; the quarter wave is 48.22 Hz."""
    network = HydraulicNetwork(
        "oil",
        [
            Supply("open", 1e6),
            Tank("tank"),
            Node("end", 0.0, start=1e6),
            Leak("none", "end", "tank", 0.0),
            Hose("hose", "open", "end", 5.0, 0.012, cells=cells),
        ],
        oil=Oil(modulus=8e8, density=860.0, viscosity=1e-9),
    )
    poles = np.linalg.eigvals(jo.simulation.linearise(jo.compile(alone(network))).A)
    found = np.abs(poles.imag[np.abs(poles) > 10.0]) / (2 * math.pi)
    speed = math.sqrt(8e8 / 860)
    wanted = 2 * cells * math.sin(math.pi / (2 * (2 * cells + 1))) / (5 / speed) / (2 * math.pi)
    assert found.min() == pytest.approx(wanted, rel=1e-9)
    assert expected is None or wanted == pytest.approx(expected, rel=1e-10)
    assert speed / 20 == pytest.approx(48.224282217, rel=1e-10)


def top(x: Any) -> float:
    """Return the largest value of the parabola through the largest sample and its neighbours."""
    k = int(np.argmax(x))
    slope, bend = (x[k + 1] - x[k - 1]) / 2, x[k + 1] - 2 * x[k] + x[k - 1]
    return float(x[k] - slope**2 / (2 * bend))


def test_h9_column_that_tears() -> None:
    """Vapour opens and closes where it opened; then the same momentum is stopped."""
    body = jo.RigidBody("mass", 10.0, (1, 1, 1), position=(0.5, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    size = {"bore": math.sqrt(4 * 20e-4 / math.pi), "stroke": 0.6, "closed": 0.45}
    plunger = HydraulicCylinder(
        "c", jo.ground["origin"], body["origin"], "A", piston_volume=1e-4, **size
    )
    network = HydraulicNetwork("oil", [Node("A"), plunger], oil=STIFF)
    start = jo.Initial(rail.displacement, rate=1.0)
    sensors = StateSensor("p", network["A"]), StateSensor("vapour", network["A_vapour"])
    model = jo.compile(jo.Mechanism(body, rail, network, start, *sensors))
    step = 8.16721805442e-6 / 20  # vapour opens at the end of a step, and closes at one, nearly
    assert 0.102040816106 / step % 1.0 < 0.01
    solver = jo.RK4(step)
    run = jo.simulate(model, 32160 * 8 * step, solver=solver, output_step=8 * step)
    vapour, p = run["vapour"][:, 0], run["p"][:, 0] + 1e5
    opens = np.flatnonzero(vapour > 0)
    closes = opens[0] + np.flatnonzero(vapour[opens[0] :] == 0)[0]
    assert run.time[opens[0] - 1] <= 8.16721805442e-6 <= run.time[opens[0]]
    assert run.time[closes - 1] <= 0.102040816106 <= run.time[closes]
    assert top(vapour) == pytest.approx(5.1012241052e-5, rel=1e-11)
    assert top(p) == pytest.approx(7862682.83439, rel=1e-9)
    assert p[opens[0] : closes] == pytest.approx(2e3, abs=1e-6)


def four_bar(core: str, book: bool = True) -> jo.Mechanism:
    """Four-bar linkage whose crank a cylinder turns; supply, valve that opens and closes again."""
    turn = np.radians(120)
    crank_end, pivot = np.array([0.5 * np.cos(turn), 0.5 * np.sin(turn), 0]), np.array([2.5, 0, 0])
    gap = pivot - crank_end
    along = (4 - 1.25**2 + gap @ gap) / (2 * np.linalg.norm(gap))
    e = gap / np.linalg.norm(gap)
    top = crank_end + along * e + math.sqrt(4 - along**2) * np.array([-e[1], e[0], 0])

    def rod(name: str, p: Any, q: Any, mass: float) -> jo.RigidBody:
        length = float(np.linalg.norm(q - p))
        half = math.atan2(q[1] - p[1], q[0] - p[0]) / 2
        inertia = mass * length**2 / 12
        return jo.RigidBody(
            name,
            mass,
            (1e-6, inertia, inertia),
            position=(p + q) / 2,
            orientation=(math.cos(half), 0, 0, math.sin(half)),
            markers={"p": (-length / 2, 0, 0), "q": (length / 2, 0, 0)},
        )

    origin = np.zeros(3)
    crank, coupler, rocker = (
        rod("crank", origin, crank_end, 10.0),
        rod("coupler", crank_end, top, 40.0),
        rod("rocker", pivot, top, 25.0),
    )
    ends = (
        ("A", jo.ground.at(origin), crank["p"]),
        ("B", crank["q"], coupler["p"]),
        ("C", coupler["q"], rocker["q"]),
        ("D", jo.ground.at(pivot), rocker["p"]),
    )
    joints = [jo.Revolute(name, a, b, axis=(0, 0, 1)) for name, a, b in ends]
    closing = where(0.5 - time, 0.4 - (time - 0.4) * 4, 0.0)
    command = where(0.1 - time, 4 * time, where(0.4 - time, 0.4, closing))
    network = HydraulicNetwork(
        "oil",
        [
            Supply("supply", 10e6),
            Tank("tank"),
            Node("p1", start=1139936.031),
            Node("p2", start=2e6),
            Orifice("inlet", "supply", "p1", flow=40 * LPM, opening=command),
            Orifice("outlet", "p2", "tank", flow=40 * LPM, opening=command),
            HydraulicCylinder(
                *("c", jo.ground.at((-0.9, 0, 0)), crank["q"], "p1", "p2"),
                bore=0.05,
                rod=0.036,
                stroke=0.6,
                closed=0.7,
                damping=1000.0,
            ),
        ],
        oil=Oil(modulus=1.5e9),
        book=book,
    )
    works = ("supplied_work", "mechanical_work", "heat_work", "stored_work") if book else ()
    powers = "inlet_heat", "outlet_heat", "c_heat"
    sensors: list[Any] = [StateSensor(x, network[x]) for x in ("p1", "p2", *powers, *works)]
    sensors += [
        jo.CoordinateSensor("angle", joints[0].angle),
        jo.RateSensor("speed", joints[0].angle),
    ]
    gravity = jo.Gravity((0, -9.81, 0))
    return jo.Mechanism(crank, coupler, rocker, *joints, gravity, network, *sensors, core=core)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("core", ["auto", "maximal"])
def test_h10_four_bar_and_its_energy(core: str) -> None:
    model = jo.compile(four_bar(core))
    run = jo.simulate(model, 0.6, solver=jo.RK4(1e-4))
    row = 3000
    turned = 120 + np.degrees(run["angle"][row, 0] - run["angle"][0, 0])
    assert turned == pytest.approx(113.809014175, abs=1e-9)
    assert run["speed"][row, 0] == pytest.approx(-0.435426544855, abs=1e-11)
    assert run["p2"][row, 0] == pytest.approx(2030073.92409, abs=1e-5)
    assert run["p1"][-1, 0] == pytest.approx(1156479.15369, abs=0.1)
    work = run["supplied_work"][:, 0]
    assert work[-1] == pytest.approx(1687.32560716, abs=1e-8)
    # the book closes, and no edge gives heat back
    other = sum(run[f"{x}_work"][:, 0] for x in ("mechanical", "heat", "stored"))
    assert np.abs(work - other).max() < 1e-12 * work[-1]
    for name in ("inlet_heat", "outlet_heat", "c_heat"):
        assert run[name].min() >= 0.0
    # the machine receives what the book says: without losses, potential and kinetic energy
    energy = run.energy
    gained = energy.kinetic + energy.potential
    gained = gained - gained[0]
    assert np.abs(run["mechanical_work"][:, 0] - gained).max() < 1e-12 * work[-1]


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize(("method", "order"), [("ROS2", 2), ("GeneralizedAlpha", 2)])
def test_order_of_a_machine_with_oil(method: str, order: int) -> None:
    model = jo.compile(four_bar("auto", book=False))
    errors = []
    for step in (5e-4, 2.5e-4):
        run = jo.simulate(model, 0.3, solver=getattr(jo, method)(step), output_step=0.3)
        errors.append(120 + np.degrees(run["angle"][-1, 0] - run["angle"][0, 0]) - 113.809014175)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.05)


def compensated(share: Any = 1.0) -> HydraulicNetwork:
    return HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Node("line", 5e-4, start=1e6),
            Pump(
                *("pump", "tank", "line", 28e-6 / REV),
                speed=25 * REV,
                leak=2e-12,
                cutoff=15e6,
                full=1e6,
                lag=0.02,
            ),
            Orifice("load", "line", "tank", flow=4 * LPM),
        ],
        oil=Oil(modulus=1.5e9),
    )


def test_h11_compensated_pump() -> None:
    network = compensated()
    model = jo.compile(alone(network, "line", "pump_share"))
    run = jo.simulate(model, 1.0, solver=jo.RK4(2e-5))
    assert run["line"].max() == pytest.approx(28554934.1349, rel=1e-6)
    rest = jo.equilibrium(model)
    found = jo.simulate(model, 1e-6, state=rest, solver=jo.ROS2(1e-6))
    assert found["line"][0, 0] == pytest.approx(15676423.0307, abs=1e-3)
    assert found["pump_share"][0, 0] == pytest.approx(0.246347817902, abs=1e-10)
    poles = np.linalg.eigvals(jo.simulation.linearise(model, rest).A)
    assert np.abs(poles.imag - 371.023769687).min() < 1e-5

    def rule(t: float, x: Any) -> Any:  # the same equations by hand
        p, e = x
        z = min(max((p - 15e6) / 1e6, 0.0), 1.0)
        flow = e * 28e-6 * 25 - 2e-12 * p - 0.1 * KV * p / (p * p + 1e8) ** 0.25
        return [1.5e9 / 5e-4 * flow, (1 - z * z * (3 - 2 * z) - e) / 0.02]

    other = solve_ivp(rule, (0, 0.05), [1e6, 1.0], "DOP853", rtol=1e-12, atol=1e-9, max_step=1e-4)
    assert run["line"][2500, 0] == pytest.approx(other.y[0, -1], rel=1e-6)


def test_h11_losses_of_wilson() -> None:
    network = HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Supply("high", 20e6),
            Pump(
                *("pump", "tank", "high", 28e-6 / REV),
                speed=25 * REV,
                slip=1e-9,
                drag=2e4,
                friction=0.01,
            ),
        ],
        oil=Oil(viscosity=0.04),
    )
    names = "pump_flow", "pump_torque", "pump_heat", "supplied_power", "heat_power"
    run = run_alone(network, 1e-3, *names)
    q, torque = run["pump_flow"][0, 0], run["pump_torque"][0, 0]
    assert q / (28e-6 * 25) == pytest.approx(0.996816901138, rel=1e-11)
    D, w = 28e-6 / REV, 25 * REV
    loss = 2e4 * 0.04 * D * w + 0.01 * D * 20e6
    assert torque == pytest.approx(D * 20e6 + loss, rel=1e-6)
    assert run["pump_heat"][0, 0] == pytest.approx(torque * w - q * 20e6, rel=1e-9)


@pytest.mark.parametrize(("flow", "expected"), [("mass", 6703772.00344), ("volume", 6666666.66667)])
def test_h12_two_volumes_that_are_joined(flow: Any, expected: float) -> None:
    network = HydraulicNetwork(
        "oil",
        [
            Node("A", 1e-3, start=20e6),
            Node("B", 2e-3),
            Orifice("valve", "A", "B", flow=40 * LPM),
        ],
        oil=STIFF,
        flow=flow,
        book=True,
    )
    names = "A", "B", "heat_work", "stored_work"
    oil = [f"{x}_oil" for x in "AB"]
    model = jo.compile(alone(network, *names, *oil))
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-5), output_step=1e-2)
    assert run["A"][-1, 0] == pytest.approx(expected, rel=1e-11)
    assert run["B"][-1, 0] == pytest.approx(expected, rel=1e-11)
    if flow == "mass":
        mass = sum(run[x][:, 0] for x in oil)
        assert np.ptp(mass) < 1e-14 * mass[0]  # round-off of 50,000 steps
        stored = [1.2e9 * (math.exp(p / 1.2e9) - 1 - p / 1.2e9) for p in (20e6, expected)]
        heat = 1e-3 * stored[0] - 3e-3 * stored[1]
        assert run["heat_work"][-1, 0] == pytest.approx(heat, rel=1e-8)
    else:
        assert run["heat_work"][-1, 0] == pytest.approx(111.111111111, rel=1e-9)
    assert run["stored_work"][-1, 0] == pytest.approx(-run["heat_work"][-1, 0], rel=1e-12)


@pytest.mark.parametrize("core", CORES)
def test_faults_are_signals(core: str) -> None:
    """A leak that grows lets a load sink by its flow; a stuck spool and a lost spring."""
    body = jo.RigidBody("load", 1000.0, (1, 1, 1), position=(0, 0, 0.8))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    area = math.pi * 0.05**2 / 4
    p = 1000.0 * 9.81 / area
    network = HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Node("A", start=p),
            HydraulicCylinder(
                *("c", jo.ground["origin"], body["origin"], "A"),
                bore=0.05,
                stroke=0.5,
                closed=0.5,
                damping=1e4,
            ),
            Leak("worn", "A", "tank", jo.Ramp(0.5, 1.0) * 1e-11),
            Node("P", 1e-3),
            Pump("pump", "tank", "P", 1e-6, speed=100.0),
            ReliefValve(
                "relief", "P", "tank", setting=10e6 - jo.Ramp(1.0, 1.05) * 9e6, flow=40 * LPM
            ),
            DirectionalValve(
                *("v", "P", "tank", "B"),
                flow=1e-9,
                command=jo.Harmonic(frequency=1.0),
                frequency=30.0,
                stuck=jo.Ramp(0.2, 0.2001),
            ),
            Node("B", 1e-3),
        ],
    )
    sensors = [StateSensor(x, network[x]) for x in ("c_x", "v_spool", "P", "A")]
    speed = jo.RateSensor("speed", rail.displacement)
    gravity = jo.Gravity((0, 0, -9.81))
    model = jo.compile(
        jo.Mechanism(body, rail, gravity, network, *sensors, speed, core=core, name="faults")
    )
    run = jo.simulate(model, 2.0, solver=jo.ROS2(1e-3))
    assert np.abs(run["speed"][:500]).max() < 1e-9
    sinks = -1e-11 * run["A"][-1, 0] / area
    assert run["speed"][-1, 0] == pytest.approx(sinks, rel=1e-6)
    assert run["A"][-1, 0] == pytest.approx((1000.0 * 9.81 + 1e4 * sinks) / area, rel=1e-6)
    stuck = run["v_spool"][250:, 0]
    assert np.ptp(stuck) < 1e-3 and stuck[0] > 0.5
    assert 10e6 < run["P"][999, 0] < 11e6
    assert 1e6 < run["P"][-1, 0] < 2e6


def test_gradients_by_sizes_of_elements() -> None:
    """Bore of a cylinder and flow of an edge by complex steps, against central differences."""

    def lift(bore: float, flow: float) -> jo.Mechanism:
        load = jo.RigidBody("load", 800.0, (10, 10, 10), position=(0, 0, 0.8))
        rail = jo.Prismatic("rail", jo.ground["origin"], load["origin"], axis=(0, 0, 1))
        network = HydraulicNetwork(
            "oil",
            [
                *(Supply("high", 8e6), Tank("tank"), Node("A", start=3e6)),
                Orifice("edge", "high", "A", flow=flow * LPM),
                ReliefValve("relief", "A", "tank", setting=21e6, flow=40 * LPM),
                HydraulicCylinder(
                    *("lift", jo.ground["origin"], load["origin"], "A"),
                    bore=bore,
                    stroke=0.5,
                    closed=0.6,
                    damping=1e3,
                ),
            ],
        )
        speed = jo.RateSensor("speed", rail.displacement)
        return jo.Mechanism(load, rail, network, jo.Gravity((0, 0, -9.81)), speed)

    sizes, solver = {"bore": 0.063, "flow": 10.0}, jo.ROS2(1e-3)
    parameters = [jo.Parameter(name, size) for name, size in sizes.items()]
    study = jo.study(lift, parameters, {"v": "max(speed)"}, t_end=0.1, solver=solver)
    found = jo.design.gradient(study)
    assert found.how == (("complex step", "complex step"),)
    for name, size in sizes.items():
        ends = [
            jo.simulate(jo.compile(lift(**{**sizes, name: x})), 0.1, solver=solver)["speed"].max()
            for x in (size * (1 + 1e-5), size * (1 - 1e-5))
        ]
        assert found["v", name] == pytest.approx((ends[0] - ends[1]) / (2e-5 * size), rel=1e-6)
        assert abs(found["v", name]) > 1e-3
