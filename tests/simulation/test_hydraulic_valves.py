"""Valves, pumps with maps and thermal accumulators: closed forms between given pressures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from jousto import hydraulics as h
from simulation.test_hydraulics import KV, LPM, REV, STIFF, alone, run_alone

FLOW = {"flow": 40 * LPM}  # KV over the root of the drop


def S(z: float) -> float:
    z = min(max(z, 0.0), 1.0)
    return z * z * (3.0 - 2.0 * z)


def g(dp: float) -> float:
    return float(dp / (dp * dp + 1e8) ** 0.25)


def between(pressures: dict[str, float], elements: list[Any], *watched: str) -> dict[str, float]:
    """Flows of elements between places with given pressures."""
    places = [h.Tank("tank"), *(h.Supply(name, p) for name, p in pressures.items())]
    run = run_alone(h.HydraulicNetwork("oil", [*places, *elements]), 1e-4, *watched)
    return {name: float(run[name][0, 0]) for name in watched}


def reduced(start: float) -> jo.Model:
    """A reducing valve before an orifice that is 30 % open."""
    network = h.HydraulicNetwork(
        "oil",
        [
            *(h.Supply("P", 20e6), h.Tank("tank"), h.Node("A", 1e-4, start=start)),
            h.ReducingValve("valve", "P", "A", setting=5e6, full=5e5, **FLOW),
            h.Orifice("load", "A", "tank", opening=0.3, **FLOW),
        ],
    )
    return jo.compile(alone(network, "A"))


def test_a_reducing_valve_holds_the_pressure_behind_it(recwarn: pytest.WarningsRecorder) -> None:
    """The pressure at which the valve passes what the orifice takes."""

    def flow(p: float) -> float:
        return (1.0 - S((p - 5e6) / 5e5)) * g(20e6 - p) - 0.3 * g(p)

    wanted = brentq(flow, 5e6, 5.5e6, xtol=1e-6)
    run = jo.simulate(reduced(5e6), 0.005, solver=jo.GeneralizedAlpha(2e-6))
    assert run["A"][-1, 0] == pytest.approx(wanted, rel=1e-9)
    assert not recwarn.list
    closes = r"reducing valve 'valve' \(full\) of hydraulics 'oil' by 100 % at 0.001 s"
    with pytest.warns(jo.JoustoWarning, match=closes):  # 12 MPa in the first step
        jo.simulate(reduced(0.0), 0.01, solver=jo.GeneralizedAlpha(1e-3))


def test_flows_of_valves_between_given_pressures() -> None:
    at = {"five": 5e6, "eight": 8e6, "eleven": 11e6, "twenty": 20e6, "held": 5.7e6}
    valves = [
        h.ReducingValve("reducing", "twenty", "held", "tank", setting=5e6, full=5e5, **FLOW),
        h.SequenceValve("below", "eight", "five", setting=10e6, full=2e6, **FLOW),
        h.SequenceValve("half", "eleven", "five", setting=10e6, full=2e6, **FLOW),
        h.SequenceValve("drained", "eleven", "five", "eight", setting=2e6, full=2e6, **FLOW),
        h.ShuttleValve("left", "eight", "five", "tank", **FLOW),
        h.ShuttleValve("right", "five", "eight", "tank", **FLOW),
        h.PilotCheckValve("free", "eight", "five", "tank", **FLOW),
        h.PilotCheckValve("shut", "tank", "eleven", "tank", **FLOW),
        h.PilotCheckValve("pilot", "tank", "twenty", "eight", ratio=2.51875, **FLOW),
    ]
    names = {
        "reducing_flow": 0.0,
        "reducing_tank_flow": S(0.4) * g(5.7e6),
        "below_flow": 0.0,
        "half_flow": S(0.5) * g(6e6),
        "drained_flow": S(0.5) * g(6e6),
        "left_a_flow": g(8e6),
        "left_b_flow": 0.0,
        "right_a_flow": 0.0,
        "right_b_flow": g(8e6),
        "free_flow": g(3e6),
        "shut_flow": 0.0,
        "pilot_flow": -S((2.51875 * 8e6 - 20e6 - 5e4) / 1.5e5) * g(20e6),
    }
    found = between(at, valves, *names)
    for name, wanted in names.items():
        assert found[name] == pytest.approx(KV * wanted, rel=1e-10, abs=1e-18), name
    assert found["pilot_flow"] < -0.1 * KV * g(20e6)


def test_a_flow_control_valve_holds_its_flow() -> None:
    """From margin + full/2 on; below that it is an orifice, as it is backwards."""
    at = {"little": 5e5, "enough": 1.01e6, "twenty": 20e6}
    how = {"flow": 10 * LPM, "margin": 8e5, "full": 4e5}
    valves = [h.FlowControlValve(f"{name}_", name, "tank", **how) for name in at]
    valves.append(h.FlowControlValve("half", "twenty", "tank", opening=0.5, **how))
    valves.append(h.FlowControlValve("back", "tank", "twenty", **how))
    found = between(at, valves, *(f"{one.name}_flow" for one in valves))
    kv = 10 * LPM / g(8e5)
    assert found["little__flow"] == pytest.approx(kv * g(5e5), rel=1e-12)
    assert found["enough__flow"] == pytest.approx(10 * LPM, rel=1e-12)
    assert found["twenty__flow"] == pytest.approx(10 * LPM, rel=1e-12)
    assert found["half_flow"] == pytest.approx(5 * LPM, rel=1e-12)
    assert found["back_flow"] == pytest.approx(-kv * g(20e6), rel=1e-12)
    # its slope over the drop is 1 - S: the drop at the middle of the way is that of its integral
    middle = between({"p": 8e5}, [h.FlowControlValve("v", "p", "tank", **how)], "v_flow")
    drop = 6e5 + 4e5 * (0.5 - 0.5**3 + 0.5**4 / 2)
    assert middle["v_flow"] == pytest.approx(kv * g(drop), rel=1e-12)


MAP = h.EfficiencyMap(
    speeds=[100.0, 200.0],
    pressures=[5e6, 20e6],
    volumetric=[[0.95, 0.88], [0.97, 0.93]],
    mechanical=[[0.90, 0.93], [0.87, 0.92]],
)


@pytest.mark.parametrize("speed", [200.0, -200.0])
@pytest.mark.parametrize(("p", "k"), [(5e6, 0), (20e6, 1)])
def test_a_pump_has_the_efficiencies_of_its_map(speed: float, p: float, k: int) -> None:
    """Pumping, it gives less flow and takes more torque; driven by the oil, the same losses."""
    D = 28e-6 / REV
    names = "pump_flow", "pump_torque", "pump_heat"
    pump = h.Pump("pump", "tank", "high", D, speed=speed, map=MAP)
    found = between({"high": p}, [pump], *names)
    lost = D * 200.0 * (1.0 - MAP.volumetric[1, k])
    drag = D * p * (1.0 / MAP.mechanical[1, k] - 1.0)
    sign = np.sign(speed)
    assert found["pump_flow"] == pytest.approx(D * speed - lost, rel=1e-12)
    assert found["pump_torque"] == pytest.approx(D * p + sign * drag, rel=1e-6)
    assert found["pump_heat"] == pytest.approx(lost * p + drag * 200.0, rel=1e-6)
    if speed > 0:
        assert found["pump_flow"] / (D * speed) == pytest.approx(MAP.volumetric[1, k], rel=1e-12)
        assert D * p / found["pump_torque"] == pytest.approx(MAP.mechanical[1, k], rel=1e-6)


def test_a_pump_with_little_pressure_at_its_inlet_gives_less() -> None:
    """Net positive suction head of 20 kPa over the vapour's 2 kPa: half of it, none, all."""
    inlets = {"half": 12e3 - 1e5, "none": 2e3 - 1e5, "all_": 22e3 - 1e5}
    pumps = [h.Pump(f"p{x}", x, "tank", 1e-6, speed=100.0, suction=2e4) for x in inlets]
    found = between(inlets, pumps, *(f"p{x}_flow" for x in inlets))
    assert found["phalf_flow"] == pytest.approx(0.5e-4, rel=1e-10)
    assert found["pnone_flow"] == pytest.approx(0.0, abs=1e-18)
    assert found["pall__flow"] == pytest.approx(1e-4, rel=1e-10)


GAS = 10e-3 * 9.1e6 / 9.2e6  # m3 of gas at the start, by the temperature of the wall


def charged(thermal: float) -> Any:
    """2 l of oil go into 10 l of gas of 9 MPa within 0.1 s; then nothing moves for 5 s."""
    fill = jo.Table([0.0, 0.01, 0.09, 0.1, 0.11], [0.0, 1.0, 1.0, 0.0, 0.0])
    total = 0.01 / 2 + 0.08 + 0.01 / 2
    network = h.HydraulicNetwork(
        "oil",
        [
            *(h.Tank("tank"), h.Node("n", 1e-9, start=9.1e6), h.Leak("no", "n", "tank", 0.0)),
            h.FlowSource("in", "n", fill * (2e-3 / total)),
            h.Accumulator("gas", "n", 10e-3, 9e6, thermal=thermal),
        ],
        oil=STIFF,
        book=True,
    )
    works = ("supplied_work", "stored_work", "heat_work")
    names = "n", "gas_oil", "gas_temperature", *works
    model = jo.compile(alone(network, *names))
    return jo.simulate(model, 5.0, solver=jo.ROS2(2.5e-4), output_step=0.05)


def test_gas_of_an_accumulator_cools_to_its_wall() -> None:
    """At constant volume T falls to that of the wall as exp(-t/tau), and the pressure with it."""
    run = charged(2.0)
    p, T, t = run["n"][:, 0] + 1e5, run["gas_temperature"][:, 0], run.time
    late = t > 0.12
    start = np.flatnonzero(late)[0]
    fall = np.exp(-(t[late] - t[start]) / 2.0)
    assert T[late] - 1.0 == pytest.approx((T[start] - 1.0) * fall, rel=1e-5)
    assert p[late] / p[start] == pytest.approx(T[late] / T[start], rel=1e-6)
    assert T[start] > 1.08
    volume = 10e-3 - run["gas_oil"][late, 0]
    # p V = m R T, with the temperature of the wall at the precharge
    assert p[late] * volume == pytest.approx(9.1e6 * 10e-3 * T[late], rel=1e-12)
    work = run["supplied_work"][:, 0]
    other = run["stored_work"][:, 0] + run["heat_work"][:, 0]
    assert other == pytest.approx(work, rel=1e-9, abs=1e-9 * work[-1])
    # an ideal gas: what it stores is m cv (T - T_wall) less the work of the atmosphere
    oil = run["gas_oil"][-1, 0] - run["gas_oil"][0, 0]
    assert oil == pytest.approx(2e-3, rel=1e-5)
    stored = 9.1e6 * 10e-3 / 0.4 * (T[-1] - 1.0) - 1e5 * oil
    assert run["stored_work"][-1, 0] == pytest.approx(stored, rel=1e-5)


@pytest.mark.parametrize(("thermal", "exponent"), [(1e6, 1.4), (1e-4, 1.0)])
def test_fast_and_slow_gas_have_their_exponents(thermal: float, exponent: float) -> None:
    """With a thermal time constant of days p V^1.4 is constant, with one of 0.1 ms p V."""
    p = charged(thermal)["n"][-1, 0] + 1e5
    assert p == pytest.approx(9.2e6 * (GAS / (GAS - 2e-3)) ** exponent, rel=2e-6)


def test_what_new_elements_refuse() -> None:
    with pytest.raises(jo.InputError, match="full is 2e.06 Pa, must be at most twice the margin"):
        h.FlowControlValve("v", "A", "B", flow=1e-4, full=2e6)
    with pytest.raises(jo.InputError, match="has a map and leak, slip, drag or friction"):
        h.Pump("p", "A", "B", 1e-6, speed=1.0, map=MAP, leak=1e-12)
    sizes: dict[str, Any] = {
        "speeds": [100.0],
        "pressures": [0.0, 1e6],
        "volumetric": [[1.2]],
        "mechanical": [[1]],
    }
    with pytest.raises(jo.InputError) as found:
        h.EfficiencyMap(**sizes)
    text = str(found.value)
    for part in ("pressures begins at 0, must be positive", "speeds has 1 knots", "1.2, must be"):
        assert part in text
    with pytest.raises(jo.InputError, match="thermal needs the ratio of the heat capacities"):
        h.Accumulator("gas", "A", 1e-3, 1e6, 1.0, thermal=1.0)
    assert math.isfinite(h.Accumulator("gas", "A", 1e-3, 1e6, thermal=1.0).volume)
