"""States in model files equal those of Python; what is wrong is named with its line."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import States, StateSensor, rate
from jousto.schema.read import parse_model

MODEL = """
bodies: [{name: wheel, mass: 1, inertia: [1e-4, 1e-4, 1e-4]}]
joints: [{type: revolute, name: axle, a: ground.origin, b: wheel.origin, axis: [0, 0, 1]}]
states:
  - type: states
    name: winding
    initial: {i: 100 mA}
    inputs: {u: 12 V, w: rate(axle.angle), q: {type: harmonic, frequency: 2}}
    rates: {i: (u + q - 1.0*i - 0.05*w)/0.5e-3}
    outputs: {torque: 0.05*i}
    forces: {axle.angle: 0.05*i}
    sizes: {i: 2 A}
  - {type: states, name: lag, initial: {y: 0}, inputs: {x: winding.torque},
     rates: {y: (x - y)/0.01}}
sensors:
  - {type: state, name: i, of: winding.i, unit: A}
  - {type: state, name: y, of: lag.y, unit: N m}
"""


def test_states_equal_the_python_constructors() -> None:
    read = parse_model(MODEL).mechanism
    (axle,) = read.joints
    winding = States(
        "winding",
        {"i": 0.1},
        {"i": "(u + q - 1.0*i - 0.05*w)/0.5e-3"},
        inputs={"u": 12.0, "w": rate(axle.angle), "q": jo.Harmonic(frequency=2.0)},
        outputs={"torque": "0.05*i"},
        forces={axle.angle: "0.05*i"},
        sizes={"i": 2.0},
    )
    lag = States("lag", {"y": 0.0}, {"y": "(x - y)/0.01"}, inputs={"x": "winding.torque"})
    sensors = StateSensor("i", winding["i"], unit="A"), StateSensor("y", lag["y"], unit="N m")
    made = jo.Mechanism(*read.bodies, axle, winding, lag, *sensors)
    runs = [jo.simulate(jo.compile(one), 0.01, solver=jo.RK4(1e-4)) for one in (read, made)]
    for name in ("i", "y"):
        assert np.array_equal(runs[0][name], runs[1][name])
        assert runs[0][name][-1, 0] != 0.0
    assert [x.unit for x in read.sensors] == ["A", "N m"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("i: 100 mA", "i: many", "7: states.0.initial.i: 'many' is no number with a unit"),
        ("rate(axle.angle)", "rate(axle.angel)", "8: .*joint 'axle' has no angel"),
        ("rate(axle.angle)", "rate(2)", "8: "),
        ("rate(axle.angle)", "open('x')", "8: .*not allowed"),
        ("0.05*w)", "0.05*v)", "nothing is called 'v'"),
        ("winding.torque}", "winding.tork}", "needs 'tork' of block 'winding'"),
        ("winding.torque}", "winder.torque}", "no block 'winder'; did you mean 'winding'"),
        ("axle.angle: 0.05*i", "axl.angle: 0.05*i", "11: .*unknown joint 'axl'|axl"),
        ("of: winding.i", "of: winding.j", "needs 'j' of block 'winding'"),
        ("unit: A}", "unit: X}", "unknown unit 'X'"),
        ("    sizes:", "    size:", "12: states.0: unknown key 'size'|size"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, message: str) -> None:
    assert old in MODEL
    with pytest.raises(InputError, match=message):
        jo.compile(parse_model(MODEL.replace(old, new)).mechanism)


BLOCKS = """
bodies: [{name: cart, mass: 1, inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: cart.origin, axis: [1, 0, 0]}]
states:
  - {type: linear-system, name: system, inputs: [rail.displacement, {type: harmonic, frequency: 2}],
     A: [[-2, 1], [0, -3]], B: [[1, 0], [0, 1]], C: [[1, 1]], D: [[0.5, 0]], initial: [1, 2]}
  - {type: transfer-function, name: measured, input: rail.displacement, numerator: [1],
     denominator: [1e-3, 0.05, 1]}
  - {type: sum, name: error, inputs: [1 m, measured.y], gains: [1, -1]}
  - {type: pid, name: pid, reference: 100 cm, measured: measured.y, kp: 8, ki: 4, kd: 4, limit: 1.5,
     anti_windup: clamping, feedforward: 0.1*system.y}
  - {type: lead, name: lead, input: pid.u, lead: 30 ms, lag: 10 ms}
  - {type: delay, name: late, input: lead.y, time: 15 ms, initial: 0.1, points: 50, size: 2}
  - {type: lag, name: motor, input: late.y, time: 20 ms}
  - {type: rate-limit, name: slow, input: motor.y, rising: 20}
  - {type: saturation, name: limited, input: slow.y, lower: -1.2, upper: 1.2}
  - {type: dead-band, name: band, input: limited.y, lower: -0.1, upper: 0.1}
  - {type: switch, name: chosen, condition: error.y - 0.5, positive: band.y, otherwise: limited.y}
  - {type: product, name: power, inputs: [chosen.y, rate(rail.displacement)]}
  - {type: integrator, name: work, input: power.y, gain: 2}
  - {type: sampled, name: digital, period: 50 ms, initial: {u: 0, n: 0}, phase: 10 ms,
     inputs: {y: chosen.y, x: rail.displacement}, updates: {u: 0.5*u + y - 0.1*x, n: n + 1}}
  - {type: sampled-pid, name: computer, reference: 1, measured: rail.displacement, period: 20 ms,
     kp: 2, ki: 1, kd: 0.1, limit: 3, method: tustin, latency: 5 ms, jitter: 1 ms, seed: 4}
  - {type: sampled-transfer-function, name: mean, input: computer.u, numerator: [1, 1],
     denominator: [2, 0], period: 20 ms, phase: 10 ms}
  - {type: relay, name: valve, input: rail.displacement, lower: 0.001, upper: 0.002, on: 0.2}
  - {type: play, name: back, input: digital.u + valve.y + 0.1*mean.y, play: 0.01}
  - {type: bouc-wen, name: wires, coordinate: rail.displacement, stiffness: 5 N/m, share: 0.1,
     beta: 3, gamma: 1, exponent: 2}
  - {type: lookup, name: curve, input: back.y, at: [-2, 0, 2], values: [-1, 0, 3],
     interpolation: parabola, outside: line}
  - {type: lookup-map, name: map, x: curve.y, y: rail.displacement, at_x: [-2, 2], at_y: [0, 1, 2],
     values: [[0, -1, -2], [2, 3, 2]], interpolation: natural}
  - {type: force, name: push, coordinate: rail.displacement, force: map.z}
sensors:
  - {type: state, name: work, of: work.y, unit: J}
  - {type: state, name: y, of: system.y}
  - {type: state, name: n, of: digital.n}
  - {type: coordinate, name: x, coordinate: rail.displacement}
"""


def test_blocks_equal_the_python_constructors() -> None:
    read = parse_model(BLOCKS).mechanism
    (rail,) = read.joints
    s, b = rail.displacement, jo.mechanism
    tf = b.TransferFunction("measured", s, [1.0], [1e-3, 0.05, 1.0])
    system = b.LinearSystem(
        "system",
        [s, jo.Harmonic(frequency=2.0)],
        *([[-2, 1], [0, -3]], [[1, 0], [0, 1]], [[1, 1]], [[0.5, 0]]),
        initial=[1, 2],
    )
    error = b.Adder("error", [1.0, tf["y"]], [1, -1])
    gains = {"kp": 8.0, "ki": 4.0, "kd": 4.0, "limit": 1.5, "anti_windup": "clamping"}
    pid = b.PIDController("pid", 1.0, tf["y"], feedforward=0.1 * system["y"], **gains)
    lead = b.Lead("lead", pid["u"], 0.03, 0.01)
    late = b.Delay("late", lead["y"], 0.015, initial=0.1, points=50, size=2.0)
    motor = b.Lag("motor", late["y"], 0.02)
    slow = b.RateLimit("slow", motor["y"], 20.0)
    limited = b.Saturation("limited", slow["y"], -1.2, 1.2)
    band = b.DeadBand("band", limited["y"], -0.1, 0.1)
    chosen = b.Switch("chosen", error["y"] - 0.5, band["y"], limited["y"])
    power = b.Multiplier("power", [chosen["y"], rate(s)])
    work = b.Integrator("work", power["y"], 2.0)
    inputs = {"y": chosen["y"], "x": s}
    updates = {"u": "0.5*u + y - 0.1*x", "n": "n + 1"}
    digital = b.Sampled("digital", 0.05, {"u": 0.0, "n": 0.0}, updates, inputs=inputs, phase=0.01)
    valve = b.Relay("valve", s, 0.001, 0.002, on=0.2)
    computer = b.SampledPID(
        *("computer", 1.0, s, 0.02),
        kp=2.0,
        ki=1.0,
        kd=0.1,
        limit=3.0,
        method="tustin",
        latency=5e-3,
        jitter=1e-3,
        seed=4,
    )
    mean = b.SampledTransferFunction("mean", computer["u"], [1, 1], [2, 0], 0.02, phase=0.01)
    back = b.Play("back", digital["u"] + valve["y"] + 0.1 * mean["y"], 0.01)
    wires = b.BoucWen("wires", s, 5.0, 0.1, 3.0, 1.0, 2.0)
    curve = b.Lookup(
        *("curve", back["y"], [-2, 0, 2], [-1, 0, 3]), interpolation="parabola", outside="line"
    )
    table = b.LookupMap(
        *("map", curve["y"], s, [-2, 2], [0, 1, 2], [[0, -1, -2], [2, 3, 2]]),
        interpolation="natural",
    )
    push = b.BlockForce("push", s, table["z"])
    blocks = system, tf, error, pid, lead, motor, slow, limited, band, chosen, power, work, push
    blocks = *blocks, curve, table, digital, computer, mean, valve, back, wires, late
    sensors = (
        StateSensor("work", work["y"], unit="J"),
        StateSensor("y", system["y"]),
        StateSensor("n", digital["n"]),
        jo.CoordinateSensor("x", s),
    )
    made = jo.Mechanism(*read.bodies, rail, *blocks, *sensors)
    runs = [jo.simulate(jo.compile(one), 1.0, solver=jo.RK4(1e-3)) for one in (read, made)]
    for name in ("work", "y", "x", "n"):
        assert np.array_equal(runs[0][name], runs[1][name])
        assert abs(runs[0][name][-1, 0]) > 1e-3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("input: pid.u", "input: pid.v", "needs 'v' of block 'pid'"),
        ("input: lead.y", "inputs: lead.y", "inputs"),
        ("anti_windup: clamping", "anti_windup: clamp", "11: .*anti_windup"),
        ("[1 m, measured.y]", "[1 m, measured.y, 2]", "3 inputs and 2 gains"),
        ("numerator: [1]", "numerator: [1, 0, 0, 1]", "degree 3"),
        ("time: 20 ms", "time: 20 mm", "mm"),
    ],
)
def test_what_is_wrong_of_blocks_is_named(old: str, new: str, message: str) -> None:
    assert old in BLOCKS
    with pytest.raises(InputError, match=message):
        jo.compile(parse_model(BLOCKS.replace(old, new)).mechanism)


OIL = """
bodies:
  - {name: load, mass: 2000, inertia: [1, 1, 1], position: [0.8, 0, 0]}
  - {name: rotor, mass: 1, inertia: [0.1, 0.1, 0.1]}
joints:
  - {type: prismatic, name: rail, a: ground.origin, b: load.origin, axis: [1, 0, 0]}
  - {type: revolute, name: axle, a: ground.origin, b: rotor.origin, axis: [0, 0, 1]}
states:
  - {type: states, name: stick, initial: {u: 0}, rates: {u: (1 - u)/0.1}}
  - type: hydraulics
    name: oil
    oil: {modulus: 1.2 GPa}
    transition: 0.1 bar
    elements:
      - {type: tank, name: tank}
      - {type: node, name: A, start: 20 bar}
      - {type: node, name: B, volume: 0.2 l, start: 2 MPa}
      - {type: node, name: P, volume: 1 l, start: 1 MPa}
      - {type: pump, name: pump, a: tank, b: P, displacement: 28 cm3/rev, speed: 1500 rpm}
      - {type: hydraulic-motor, name: motor, a: P, b: tank, displacement: 5 cm3/rev,
         shaft: axle.angle}
      - {type: relief-valve, name: relief, a: P, b: tank, setting: 210 bar, flow: 60 l/min}
      - {type: directional-valve, name: valve, supply: P, tank: tank, a: A, b: B, flow: 40 l/min,
         drop: 3.5 MPa, command: 0.5*stick.u, frequency: 60 Hz,
         stuck: {type: ramp, start: 0.05, end: 0.06}}
      - {type: cylinder, name: lift, a: ground.origin, b: load.origin, piston: A, rod_side: B,
         bore: 63 mm, rod: 36 mm, stroke: 40 cm, closed: 0.5, damping: 2e4,
         rod_cushion: {length: 30 mm, flow: 80 l/min}}
sensors:
  - {type: state, name: A, of: oil.A, unit: Pa}
  - {type: state, name: x, of: oil.lift_x, unit: m}
"""


def test_a_hydraulic_network_equals_the_python_constructors() -> None:
    from jousto import hydraulics as h
    from jousto.mechanism import Expression

    read = parse_model(OIL).mechanism
    load, rotor = read.bodies
    rail, axle = read.joints
    rev, litre = 2 * np.pi, 1e-3 / 60
    stick = States("stick", {"u": 0.0}, {"u": "(1 - u)/0.1"})
    oil = h.HydraulicNetwork(
        "oil",
        [
            h.Tank("tank"),
            h.Node("A", start=2e6),
            h.Node("B", 2e-4, start=2e6),
            h.Node("P", 1e-3, start=1e6),
            h.Pump("pump", "tank", "P", 28e-6 / rev, speed=25 * rev),
            h.HydraulicMotor("motor", "P", "tank", 5e-6 / rev, shaft=axle.angle),
            h.ReliefValve("relief", "P", "tank", setting=21e6, flow=60 * litre),
            h.DirectionalValve(
                *("valve", "P", "tank", "A", "B"),
                flow=40 * litre,
                command=0.5 * stick["u"],
                frequency=60.0,
                stuck=jo.Ramp(0.05, 0.06),
            ),
            h.HydraulicCylinder(
                *("lift", jo.ground["origin"], load["origin"], "A", "B"),
                bore=0.063,
                rod=0.036,
                stroke=0.4,
                closed=0.5,
                damping=2e4,
                rod_cushion=h.Cushion(length=0.03, flow=80 * litre),
            ),
        ],
        oil=h.Oil(modulus=1.2e9),
    )
    assert isinstance(oil["A"], Expression)
    sensors = StateSensor("A", oil["A"], unit="Pa"), StateSensor("x", oil["lift_x"], unit="m")
    made = jo.Mechanism(load, rotor, rail, axle, stick, oil, *sensors)
    models = [jo.compile(one) for one in (read, made)]
    first, second = ([f.data for f in model.forces if f.kind == "network"][0] for model in models)
    assert first == pytest.approx(second, rel=1e-13)  # program and numbers
    run = jo.simulate(models[0], 0.2, solver=jo.ROS2(2e-4))
    assert run["x"][-1, 0] - run["x"][0, 0] > 1e-3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("setting: 210 bar", "setting: 210 l", "states.1.elements.6.setting: .*pressure"),
        ("setting: 210 bar", "settings: 210 bar", "settings"),
        ("piston: A", "piston: AA", "piston of cylinder 'lift' is 'AA', which is no node"),
        ("28 cm3/rev", "28 cm3", "displacement"),
        ("type: tank", "type: tnk", "no .* type 'tnk'; did you mean 'tank'"),
        ("axle.angle", "axle.angel", "joint 'axle' has no angel"),
        ("a: ground.origin, b: load.origin, piston", "a: ground.origin, b: lod.origin, piston",
         "no body 'lod'"),
        ("0.5*stick.u", "0.5*stik.u", "no block 'stik'; did you mean 'stick'"),
        ("0.5*stick.u", "0.5*(stick.u", "elements.7.command"),
        ("closed: 0.5", "closed: 0.1", "not within closed to closed"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_a_network_is_named(old: str, new: str, message: str) -> None:
    assert old in OIL
    with pytest.raises(InputError, match=message):
        jo.compile(parse_model(OIL.replace(old, new)).mechanism)


DRIVE = """
bodies:
  - {name: rotor, mass: 1, inertia: [1e-3, 1e-3, 1e-3]}
  - {name: drum, mass: 50, inertia: [1, 1, 1]}
joints:
  - {type: revolute, name: shaft, a: ground.origin, b: rotor.origin, axis: [0, 0, 1]}
  - {type: revolute, name: axle, a: ground.origin, b: drum.origin, axis: [0, 0, 1]}
states:
  - {type: pid, name: speed, reference: 50 rad/s, measured: rate(shaft.angle), kp: 1, ki: 10,
     limit: 20, actual: motor.wanted_q}
  - {type: synchronous-motor, name: motor, shaft: shaft.angle, resistance: 500 mohm,
     inductance_d: 2 mH, inductance_q: 3 mH, flux: 0.08 V s, pole_pairs: 4, bandwidth: 1000 rad/s,
     current: "clip(speed.u, -heat.limit, heat.limit)", dc_voltage: 300 V, largest_current: 20 A,
     strategy: least-current, weakening: true}
  - {type: thermal-load, name: heat, current: motor.amplitude, rated: 8 A, time: 1 min,
     largest: 20 A, trips: true}
  - {type: gearbox, name: gear, motor: shaft.angle, coordinate: axle.angle, ratio: 20,
     stiffness: 1e5 N m/rad, damping: 100 N m s/rad, backlash: 0.1 deg, efficiency: 90 %}
  - {type: brake, name: brake, coordinate: shaft.angle, torque: 12 N m, stiffness: 1e4 N m/rad,
     release: {type: ramp, start: 0, end: 10 ms}, lag: 30 ms}
  - {type: dc-motor, name: fan, shaft: axle.angle, voltage: 12 V, resistance: 1 ohm,
     inductance: 0.5 mH, constant: 0.05 N m/A, ratio: -3}
sensors:
  - {type: state, name: torque, of: motor.torque, unit: N m}
  - {type: state, name: load, of: heat.load}
  - {type: state, name: i, of: fan.current, unit: A}
  - {type: state, name: e, of: gear.windup, unit: rad}
"""


def test_electric_drives_equal_the_python_constructors() -> None:
    read = parse_model(DRIVE).mechanism
    shaft, axle = read.joints
    e, q = jo.electric, shaft.angle
    gains = {"kp": 1.0, "ki": 10.0, "limit": 20.0}
    pid = jo.mechanism.PIDController("speed", 50.0, rate(q), actual="motor.wanted_q", **gains)
    plate = (0.5, 2e-3, 3e-3, 0.08, 4)
    motor = e.SynchronousMotor(
        *("motor", q, *plate),
        current="clip(speed.u, -heat.limit, heat.limit)",
        bandwidth=1000.0,
        dc_voltage=300.0,
        largest_current=20.0,
        strategy="least-current",
        weakening=True,
    )
    heat = e.ThermalLoad("heat", motor["amplitude"], 8.0, 60.0, largest=20.0, trips=True)
    gear = e.Gearbox(
        *("gear", q, axle.angle, 20.0, 1e5, 100.0), backlash=np.deg2rad(0.1), efficiency=0.9
    )
    brake = e.Brake("brake", q, 12.0, 1e4, release=jo.Ramp(0.0, 0.01), lag=0.03)
    fan = e.DCMotor("fan", axle.angle, 12.0, 1.0, 0.5e-3, 0.05, ratio=-3.0)
    blocks = pid, motor, heat, gear, brake, fan
    sensors = [
        StateSensor("torque", motor["torque"], unit="N m"),
        StateSensor("load", heat["load"]),
        StateSensor("i", fan["current"], unit="A"),
        StateSensor("e", gear["windup"], unit="rad"),
    ]
    made = jo.Mechanism(*read.bodies, shaft, axle, *blocks, *sensors)
    runs = [jo.simulate(jo.compile(one), 0.1, solver=jo.ROS2(1e-3)) for one in (read, made)]
    for name in ("torque", "load", "i", "e"):
        assert np.abs(runs[0][name] - runs[1][name]).max() <= 1e-9 * np.abs(runs[0][name]).max()
        assert abs(runs[0][name][-1, 0]) > 1e-6


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2 mH", "2 mm", "inductance_d"),
        ("strategy: least-current", "strategy: least", "strategy"),
        ("motor.amplitude", "motor.amplitud", "needs 'amplitud' of block 'motor'"),
        ("motor: shaft.angle", "motor: shft.angle", "shft"),
        ("bandwidth: 1000 rad/s,", "", "bandwidth of the current control is missing"),
    ],
)
def test_what_is_wrong_of_drives_is_named(old: str, new: str, message: str) -> None:
    assert old in DRIVE
    with pytest.raises(InputError, match=message):
        jo.compile(parse_model(DRIVE.replace(old, new)).mechanism)
