"""Optimisation with rigid bodies outside and each part alone inside.

Numbers of the two masses and of the carried mass: closed forms of single oscillators under half a
sine, and the optimum over them by SLSQP.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.design import (
    DisplacementLimit,
    MachineProblem,
    RigidMachine,
    StressLimit,
    StructureProblem,
    optimise,
)
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.component import component
from jousto.design.optimisation.rigid_machine import rigid_machine
from jousto.design.optimisation.rigid_outside import decoupled

TIME = np.linspace(0.0, 8.0, 2001)
CHAIN = {"lower": ["1"], "upper": ["2"]}
STEEL = jo.Material(210e9, 0.3, 7850.0)


# -- two masses in a chain --------------------------------------------------------------------


def matrices(v):
    k1, k2 = 10.0 * v["b1"], 10.0 * v["b2"]
    masses = np.diag([1.0 + 0.15 * (v["b1"] + v["b2"]), 1.0 + 0.15 * v["b2"]])
    return masses, np.array([[k1 + k2, -k2], [-k2, k2]])


def push(t):
    return np.stack([np.zeros_like(t), np.where(t < 2.0, np.sin(np.pi * t / 2.0), 0.0)])


def chain(components=None, start=(2.0, 2.0)):
    pairs = zip(("b1", "b2"), start, strict=True)
    return StructureProblem(
        [jo.Parameter(name, value, bounds=(0.2, 20.0)) for name, value in pairs],
        matrices,
        push,
        TIME,
        lambda v: v["b1"] + v["b2"],
        [DisplacementLimit("structure", 0.25, "2")],
        components=components,
    )


def half_sine(t, m, k, force, end):
    """Displacement of a mass on a spring from rest under ``force sin(pi t / end)``, t < end."""
    w, W = np.sqrt(k / m), np.pi / end
    A = force / m / (w**2 - W**2)
    s = A * (np.sin(W * end) - W / w * np.sin(w * end))
    v = A * W * (np.cos(W * end) - np.cos(w * end))
    inside = A * (np.sin(W * t) - W / w * np.sin(w * t))
    return np.where(t < end, inside, s * np.cos(w * (t - end)) + v / w * np.sin(w * (t - end)))


def alone(b1, b2, beyond):
    """Displacement of the last mass: the sum of two masses that vibrate alone."""
    m1, m2 = 1.0 + 0.15 * (b1 + b2), 1.0 + 0.15 * b2
    lower = half_sine(TIME, m1 + (m2 if beyond else 0.0), 10.0 * b1, 1.0, 2.0)
    return lower + half_sine(TIME, m2, 10.0 * b2, 1.0, 2.0)


@pytest.mark.parametrize("beyond", [False, True])
def test_each_mass_of_the_chain_vibrates_alone(beyond):
    one = decoupled(chain(CHAIN), RigidMachine(beyond=beyond))
    (motion,) = one.motions(np.array([1.3, 0.7]))
    found = (motion.shapes @ motion.coordinates)[1]
    assert found == pytest.approx(alone(1.3, 0.7, beyond), abs=1e-12)


def test_a_rigid_machine_outside_changes_nothing_for_one_part():
    near = (1.4, 1.2)
    found = optimise(chain(None, near), order=0, tolerance=1e-9, machine="rigid")
    same = optimise(chain(None, near), order=0, tolerance=1e-9)
    assert found.converged
    assert found.cost == pytest.approx(same.cost, rel=1e-12)
    # order 0 ends where SLSQP sees no descent, from several starts up to 7e-8 beside this value
    assert found.cost == pytest.approx(2.648480989, rel=1e-7)
    assert found.ratio == pytest.approx(1.0, abs=1e-7)
    first = optimise(chain(None, near), tolerance=1e-8, trust=0.02, machine="rigid")
    assert first.cost == pytest.approx(2.579643884, rel=1e-8)
    assert list(first.values.values()) == pytest.approx([1.24085588, 1.33878800], rel=1e-7)
    assert first.excess == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("beyond", "cost", "peak"),
    [(False, 2.738765371, 0.2374392257), (True, 2.411241565, 0.2854425343)],
)
def test_optima_of_two_parts_alone(beyond, cost, peak):
    start = (0.8, 1.6) if beyond else (1.3, 1.4)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", JoustoWarning)
        how = RigidMachine(beyond=beyond)
        found = optimise(chain(CHAIN, start), tolerance=1e-9, trust=0.02, machine=how)
    assert found.cost == pytest.approx(cost, rel=1e-8)
    assert 0.25 * found.ratio == pytest.approx(peak, rel=1e-8)
    assert found.own_ratio == pytest.approx(1.0, abs=1e-8)
    assert np.abs(alone(*found.values.values(), beyond)).max() == pytest.approx(0.25, abs=1e-8)
    assert found.excess == pytest.approx(peak / 0.25 - 1.0, abs=1e-7)
    assert found.safe is found.kept is not beyond
    assert (found.rigid_runs, found.flexible_runs, len(found.outer)) == (2, 1, 2)
    assert sum(one.inner for one in found.outer) == len(found.history)
    text, told = str(found), [str(one.message) for one in caught]
    assert f"flexible machine {peak:.6f}"[:-2] in text and "limit 0.25 m" in text
    if beyond:
        assert "UNSAFE: the flexible machine exceeds a limit by 14.18 %" in text
        assert any("UNSAFE" in one and "14.18 %" in one for one in told)
        assert "(+14.18 %)" in text
        assert found.kkt == pytest.approx(found.ratio - 1.0)
    else:
        assert "the flexible machine keeps all limits" in text
        assert not told
        assert found.cost / 2.579643884 - 1.0 == pytest.approx(0.0617, abs=1e-4)


def test_components_that_are_no_partition():
    with pytest.raises(InputError) as caught:
        chain({"lower": ["1", "3"], "upper": ["1"]})
    text = str(caught.value)
    assert "no node '3'; did you mean" in text or "no node '3'" in text
    assert "node '1' is in 2 parts, must be in one" in text
    assert "node '2' is in 0 parts, must be in one" in text


# -- a part on a carrier that gives way -------------------------------------------------------

CARRIER, INTERFACE, MASS, FORCE, PUSHED = 3.0, 1.0, 1.0, 30.0, 0.3  # kg, kg, kg, N, s


def spring_part(k):
    """Two masses on a bar of stiffness k along x that hardly bends."""
    K = np.zeros((12, 12))
    K[np.ix_([0, 6], [0, 6])] = k * np.array([[1, -1], [-1, 1]])
    K[np.ix_([3, 9], [3, 9])] = 1e4 * np.array([[1, -1], [-1, 1]])
    bend = 1e5 * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    K[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])] = bend
    turned = np.diag([1, -1, 1, -1])
    K[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])] = turned @ bend @ turned
    M = np.diag([INTERFACE] * 3 + [1e-2] * 3 + [MASS] * 3 + [1e-2] * 3)
    ends = {"start": [0], "end": [1]}
    return jo.Part.from_matrices(M, K, [[0, 0, 0], [1, 0, 0]], node_sets=ends, name="bar")


def carried_bar(values, parts):
    reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=0))
    bar, carrier = jo.FlexibleBody("bar", reduced), jo.RigidBody("carrier", CARRIER, (1, 1, 1))
    sine = jo.mechanism.Product(jo.Harmonic(frequency=0.5 / PUSHED), jo.Step(PUSHED, 1.0, 0.0))
    return jo.Mechanism(
        carrier,
        bar,
        jo.Prismatic("rail", jo.ground["origin"], carrier["origin"], axis=(1, 0, 0)),
        jo.Fixed("weld", carrier["origin"], bar["start"]),
        jo.Force("push", carrier["origin"], (FORCE, 0, 0), signal=sine),
    )


def carried(limit=1.0, step=1e-4, build=carried_bar):
    return MachineProblem(
        [jo.Parameter("k", 100.0, bounds=(50.0, 400.0))],
        lambda v: {"bar": spring_part(v["k"])},
        build,
        [DisplacementLimit("bar", limit, "end", direction=(1, 0, 0), relative_to="start")],
        0.6,
        solver=jo.RK4(1e-4),
        output_step=step,
        cost=lambda v, parts: v["k"],
    )


def carried_between_springs(values, parts):
    """The carried bar with a spring of 30 N/m from its mass to the ground, along the bar."""
    machine = carried_bar(values, parts)
    bar = next(item for item in machine.items if isinstance(item, jo.FlexibleBody))
    anchor = jo.ground.at((3.0, 0, 0))
    return jo.Mechanism(
        *machine.items, jo.Spring("stay", jo.Distance(bar["end"], anchor), stiffness=30.0, free=2.0)
    )


def test_stiffness_of_springs_on_a_part_is_told():
    one = decoupled(carried(build=carried_between_springs), RigidMachine())
    one.freeze(one.start)
    # a mass on 100 N/m beside 30 N/m
    assert one.springs(one.start) == {"bar": pytest.approx(0.3, rel=1e-6)}
    problem = carried(limit=10.0, step=1e-3, build=carried_between_springs)
    found = optimise(problem, order=0, cycles=1, machine="rigid")
    (k,) = found.values.values()
    assert found.springs["bar"] == pytest.approx(30.0 / k, rel=1e-6)
    assert f"springs and other forces on it have {30.0 / k:.3g} of its stiffness" in str(found)
    free = decoupled(carried(), RigidMachine())
    free.freeze(free.start)
    assert free.springs(free.start) == {"bar": pytest.approx(0.0, abs=1e-12)}


def test_mass_that_carries_a_part_of_a_closed_loop():
    """Two equal bars between a carrier and a yoke: at most a bar over all that can carry it."""

    def ladder(values, parts):
        carrier = jo.RigidBody("carrier", 4.0, (0.1, 0.1, 0.1))
        yoke = jo.RigidBody("yoke", 2.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
        items = [jo.Prismatic("rail", jo.ground["origin"], carrier["origin"], axis=(0, 0, 1))]
        for name, y in (("bar", 0.0), ("second", 0.5)):
            reduced = jo.reduce(parts[name], jo.CraigBampton(["start", "end"], modes=2))
            bar = jo.FlexibleBody(name, reduced, position=(0, y, 0))
            items += [
                bar,
                jo.Fixed(f"{name} foot", carrier.at((0, y, 0)), bar["start"]),
                jo.Fixed(f"{name} head", yoke.at((0, y, 0)), bar["end"]),
            ]
        push = jo.Force("push", carrier["origin"], (0, 0, 300.0), signal=jo.Step(0.02))
        return jo.Mechanism(carrier, yoke, *items, push)

    def parts(values):
        return {name: arm_parts(values)["bar"] for name in ("bar", "second")}

    limits = [StressLimit(name, 1e9) for name in ("bar", "second")]
    one = decoupled(swing(ladder, limits, parts), RigidMachine())
    with pytest.warns(JoustoWarning, match="statically indeterminate"):
        one.freeze(one.start)
    mass = 7850 * 0.02 * 0.03 * LENGTH
    for ratio in one.carriers(one.start).values():
        assert 0.0 < ratio < mass / (4.0 + 2.0 + mass)


def closed_deflection(t, k, how):
    """Deflection of the spring by the closed form of each way of holding the part."""
    total = CARRIER + INTERFACE + MASS
    reduced, force = {
        "motion": (MASS, FORCE * MASS / total),
        "force": (
            MASS * INTERFACE / (MASS + INTERFACE),
            FORCE * (INTERFACE + MASS) / total * MASS / (MASS + INTERFACE),
        ),
        "true": (
            MASS * (CARRIER + INTERFACE) / total,
            FORCE * MASS / total,
        ),
    }[how]
    return half_sine(t, reduced, k, force, PUSHED)


@pytest.mark.parametrize(("held", "peak"), [("motion", 0.09199802831), ("force", None)])
def test_a_part_on_a_carrier_held_both_ways(held, peak):
    one = decoupled(carried(), RigidMachine(held=held))
    one.check()
    one.freeze(one.start)
    (motion,) = one.motions(one.start)
    u = motion.shapes @ motion.coordinates
    found = u[6] - u[0]
    exact = closed_deflection(motion.time, 100.0, held)
    # loads are cubics between instants of 0.1 ms; the force has a corner at 0.3 s
    assert np.abs(found) == pytest.approx(np.abs(exact), abs=1e-8)
    if peak is not None:
        assert np.abs(found).max() == pytest.approx(peak, abs=1e-8)
    assert one.carriers(one.start) == {"bar": pytest.approx(0.25, rel=1e-8)}


def test_the_truth_is_between_both_ways_and_all_are_printed():
    problem = carried(limit=0.095, step=1e-3)
    with pytest.warns(JoustoWarning, match="UNSAFE"):
        found = optimise(problem, machine="rigid", tolerance=1e-7)
    (k,) = found.values.values()
    fine = np.linspace(0.0, 0.6, 60001)
    exact = {
        how: np.abs(closed_deflection(fine, k, how)).max() for how in ("motion", "true", "force")
    }
    (peak,) = found.peaks
    assert 0.095 * peak.own == pytest.approx(exact["motion"], rel=5e-5)
    assert 0.095 * peak.true == pytest.approx(exact["true"], rel=5e-5)
    assert 0.095 * peak.other == pytest.approx(exact["force"], rel=5e-5)
    assert peak.own < peak.true < peak.other
    assert "its moving mass is 0.25 of the mass that carries it" in str(found)
    # the stiffness whose closed form meets the limit
    root = brentq(lambda k: np.abs(closed_deflection(fine, k, "motion")).max() - 0.095, 50.0, 200.0)
    assert k == pytest.approx(root, rel=2e-4)


# -- how joints hold a part -------------------------------------------------------------------

LENGTH, SIDE = 1.0, 0.005  # m, thin, so that rotary inertia is below 1e-5 of a frequency


def slender(n=12):
    return jo.Part.beam(
        LENGTH, jo.Rectangle(SIDE, SIDE), n, STEEL, theory=jo.parts.EulerBernoulli()
    )


def flexible(modes=8, plane=None, **options):
    reduced = jo.reduce(slender(), jo.CraigBampton(["start", "end"], modes=modes))
    if plane is not None:
        reduced = reduced.keep(reduced.in_plane(plane))
    return jo.FlexibleBody("bar", reduced, **options)


def first_frequency(machine, held="motion", beyond=False):
    model = jo.compile(machine)
    k = [body.name for body in model.bodies].index("bar")
    q = np.array(model.q0)
    return np.sqrt(component(model, k, q, held, beyond).w2[0])


def bending(root):
    """Circular frequency of a slender bar for a root of its characteristic equation, rad/s."""
    return root**2 * np.sqrt(210e9 * SIDE**2 / 12 / 7850) / LENGTH**2


def test_a_welded_bar_is_a_cantilever():
    bar = flexible(16)
    machine = jo.Mechanism(bar, jo.Fixed("wall", jo.ground["origin"], bar["start"]))
    assert first_frequency(machine) == pytest.approx(bending(1.87510407), rel=1e-5)
    assert first_frequency(machine, "force") == pytest.approx(bending(4.73004074), rel=2e-4)


def test_a_hinged_bar_turns_freely():
    bar = flexible()
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    # about the hinge it is pinned and free, about the other axis clamped and free
    assert first_frequency(jo.Mechanism(bar, hinge)) == pytest.approx(bending(1.87510407), rel=1e-5)
    ball = jo.Spherical("ball", jo.ground["origin"], bar["start"])
    assert first_frequency(jo.Mechanism(bar, ball)) == pytest.approx(bending(3.92660231), rel=1e-4)


def test_a_rod_between_two_bearings_is_pinned_at_both_ends():
    rod = flexible(16, "xy", position=(0.2, 0, 0))
    crank = jo.RigidBody("crank", 1.0, (1e-2, 1e-2, 1e-2))
    piston = jo.RigidBody("piston", 1.0, (1e-2, 1e-2, 1e-2), position=(1.2, 0, 0))
    machine = jo.Mechanism(
        crank,
        rod,
        piston,
        jo.Revolute("bearing", jo.ground["origin"], crank["origin"]),
        jo.Revolute("crank pin", crank.at((0.2, 0, 0)), rod["start"]),
        jo.Prismatic("bore", jo.ground["origin"], piston["origin"], axis=(1, 0, 0)),
        jo.PointOnLine("piston pin", rod["end"], piston["origin"], axis=(0, 0, 1)),
    )
    assert first_frequency(machine) == pytest.approx(bending(np.pi), rel=1e-4)


def tip_root(ratio):
    """Root of a cantilever with a point mass at its tip, ratio of its own mass."""
    return brentq(
        lambda x: (
            1
            + np.cos(x) * np.cosh(x)
            - ratio * x * (np.sin(x) * np.cosh(x) - np.cos(x) * np.sinh(x))
        ),
        0.5,
        1.87510407,
    )


def test_a_part_carries_the_mass_beyond_it():
    bar, mass = flexible(), 7850 * SIDE**2 * LENGTH
    load = jo.RigidBody("load", 2.0 * mass, (1e-9, 1e-9, 1e-9), position=(LENGTH, 0, 0))
    machine = jo.Mechanism(
        bar,
        load,
        jo.Fixed("wall", jo.ground["origin"], bar["start"]),
        jo.Fixed("grip", bar["end"], load["origin"]),
    )
    assert first_frequency(machine) == pytest.approx(bending(1.87510407), rel=1e-5)
    loaded = first_frequency(machine, beyond=True)
    assert loaded == pytest.approx(bending(tip_root(2.0)), rel=1e-5)
    # one flexible body: the machine whose other bodies are rigid is the machine
    model = jo.compile(machine)
    assert loaded == pytest.approx(2 * np.pi * jo.modes(model).frequencies[0], rel=1e-6)


# -- machines ---------------------------------------------------------------------------------


def test_the_rigid_machine_moves_as_one_of_rigid_bodies():
    text = """
    parts:
      rod: {type: beam, length: 1 m, section: {type: rectangle, width: 2 cm, height: 3 cm},
            material: S355, elements: 4,
            reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}}
    bodies: [{name: arm, part: rod}, {name: bob, mass: 2 kg, inertia: [1e-2, 2e-2, 3e-2],
              position: [1, 0, 0]}]
    joints: [{type: revolute, name: hinge, a: ground.origin, b: arm.start, axis: [0, 1, 0]},
             {type: revolute, name: wrist, a: arm.end, b: bob.origin, axis: [0, 1, 0]}]
    gravity: [0, 0, -9.81]
    sensors: [{type: position, name: bob, marker: bob.center}]
    """
    from jousto.schema.file.document import parse_document
    from jousto.schema.read import build_model

    document = parse_document(text, name="arm")
    both = (
        rigid_machine(build_model(document).mechanism),
        build_model(document, rigid=True).mechanism,
    )
    runs = []
    for machine in both:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # modes that carry no load are those of the copy
            runs.append(jo.simulate(jo.compile(machine), 1.0, solver=jo.RK4(1e-3))["bob"])
    assert runs[0] == pytest.approx(runs[1], abs=1e-10)
    assert np.ptp(runs[0][:, 2]) > 0.5


def arm_parts(values):
    section = jo.Rectangle(0.02, values["height"])
    return {"bar": jo.Part.beam(LENGTH, section, 4, STEEL, theory=jo.parts.EulerBernoulli())}


def thrown(values, parts, name="bar"):
    """A bar with a load, turned about a hinge in half a second: its own mass loads it."""
    reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=3))
    bar = jo.FlexibleBody(name, reduced, damping=0.02)
    load = jo.RigidBody("load", 0.5, (1e-3, 1e-3, 1e-3), position=(LENGTH, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    return jo.Mechanism(
        bar,
        load,
        hinge,
        jo.Fixed("grip", bar["end"], load["origin"]),
        jo.Drive("turn", hinge.angle, jo.SCurve((0.0, 0.5), (0.0, 2.0))),
    )


def swing(build=thrown, limits=None, parts=arm_parts, **options):
    return MachineProblem(
        [jo.Parameter("height", 0.03, bounds=(0.01, 0.1), unit="m")],
        parts,
        build,
        [StressLimit("bar", 60e6, criterion="s11")] if limits is None else limits,
        0.6,
        solver=jo.ROS2(step=1e-3),
        output_step=5e-3,
        **options,
    )


def test_the_outer_loop_ends_by_the_interface_loads():
    loose = optimise(swing(), machine=RigidMachine(beyond=True, load_tolerance=0.5))
    tight = optimise(swing(), machine=RigidMachine(beyond=True, load_tolerance=1e-7))
    assert loose.converged and tight.converged
    assert len(loose.outer) < len(tight.outer)
    assert tight.outer[-1].loads <= 1e-7 < tight.outer[-2].loads or np.isnan(tight.outer[-2].loads)
    assert tight.outer[-1].inner == 0
    # each outer cycle but the last runs the design and both sides of its parameter
    assert tight.rigid_runs == 3 * (len(tight.outer) - 1) + 1
    assert tight.runs >= len(tight.history)
    assert tight.flexible_runs == 1
    # the fixed point is the optimum of the decoupled problem: a run of its own meets the limit
    one = decoupled(swing(), RigidMachine(beyond=True))
    x = one.vector(tight.values)
    one.freeze(x)
    assert max(r.max() for _, _, r in esl.table_of(one, x)) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.slow
def test_one_flexible_part_that_carries_its_load_is_nearly_the_machine():
    rigid = optimise(swing(), machine=RigidMachine(beyond=True))
    whole = optimise(swing())
    assert rigid.safe
    assert abs(rigid.excess) < 0.01
    assert rigid.cost == pytest.approx(whole.cost, rel=0.01)
    # without the load it is too stiff in vibration; both reports agree with a run of their own
    light = decoupled(swing(), RigidMachine())
    light.freeze(light.start)
    table = esl.table_of(light, light.start)
    assert table[0][2].max() > 0.0


@pytest.mark.slow
def test_order_0_and_the_direct_method_run_inside():
    how = RigidMachine(beyond=True)
    first = optimise(swing(), machine=how)
    for options in ({"order": 0}, {"method": "direct"}):
        found = optimise(swing(), machine=how, **options)
        # one parameter and one limit: every method ends at the limit
        assert found.cost == pytest.approx(first.cost, rel=1e-4)
        assert found.method.endswith("rigid outside")


def test_load_cases_have_peaks_of_their_own():
    def both(values, parts):
        return {"fast": thrown(values, parts), "again": thrown(values, parts)}

    found = optimise(swing(both), machine=RigidMachine(beyond=True), tolerance=1e-3)
    assert [one.limit for one in found.peaks] == ["s11 of bar (fast)", "s11 of bar (again)"]
    assert found.peaks[0].true == pytest.approx(found.peaks[1].true, rel=1e-12)


def test_runs_that_start_without_vibration():
    def turning(values, parts):
        reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=12))
        bar = jo.FlexibleBody("bar", reduced)
        hinge = jo.Revolute("hinge", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
        return jo.Mechanism(bar, hinge, jo.Drive("turn", hinge.angle, jo.ConstantSpeed(20.0)))

    longer = DisplacementLimit("bar", 1e-4, "end", direction=(1, 0, 0), relative_to="start")
    problem = MachineProblem(
        [jo.Parameter("height", 0.03, bounds=(0.01, 0.1), unit="m")],
        arm_parts,
        turning,
        [longer],
        0.01,
        solver=jo.ROS2(step=1e-4),
        output_step=1e-3,
        state=jo.simulation.vibration_free_state,
    )
    one = decoupled(problem, RigidMachine())
    one.freeze(one.start)
    ((_, _, ratio),) = esl.table_of(one, one.start)
    # a bar that turns is longer by rho w^2 L^3 / (3 E), and does not ring about that
    closed = 7850 * 20.0**2 * LENGTH**3 / (3 * 210e9)
    assert 1e-4 * ratio[0] == pytest.approx(closed, rel=2e-3)


# -- what cannot be ---------------------------------------------------------------------------


def test_a_wrong_machine_is_told():
    for word, message in (
        ("ridgid", r"machine is 'ridgid'; did you mean 'rigid'\?"),
        (3, "machine is 3"),
    ):
        with pytest.raises(InputError, match=message):
            optimise(chain(), machine=word)
    with pytest.raises(InputError, match="held is 'both', must be 'motion' or 'force'"):
        RigidMachine(held="both")
    with pytest.raises(InputError, match="load_tolerance"):
        RigidMachine(load_tolerance=0.0)
    with pytest.raises(InputError, match="the structure is supported"):
        optimise(chain(), machine=RigidMachine(held="force"))


def test_a_machine_without_flexible_bodies():
    def stiff(values, parts):
        body = jo.RigidBody("bar", 1.0, (1, 1, 1))
        return jo.Mechanism(body, jo.Fixed("wall", jo.ground["origin"], body["origin"]))

    with pytest.raises(InputError, match="no body is flexible"):
        optimise(swing(stiff), machine="rigid")


def test_a_part_without_limits():
    def two_parts(values):
        return {**arm_parts(values), "second": arm_parts(values)["bar"]}

    def two(values, parts):
        machine = thrown(values, {"bar": parts["bar"]})
        other = jo.reduce(parts["second"], jo.CraigBampton(["start", "end"], modes=2))
        second = jo.FlexibleBody("second", other, position=(0, 1, 0))
        wall = jo.Fixed("wall", jo.ground.at((0, 1, 0)), second["start"])
        return jo.Mechanism(*machine.items, second, wall)

    with pytest.raises(InputError, match="part 'second': depends on the parameters but has no"):
        optimise(swing(two, parts=two_parts), machine="rigid")


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_a_rigid_machine_that_does_not_run():
    def stretched(values, parts):
        """Drives pull both ends of a bar apart, which only an elastic bar can follow."""
        reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=2))
        bar = jo.FlexibleBody("bar", reduced, damping=0.05)
        wall = jo.Fixed("wall", jo.ground["origin"], bar["start"])
        slide = jo.PointOnLine("slide", jo.ground.at((1, 0, 0)), bar["end"], axis=(1, 0, 0))
        pull = jo.Drive("pull", slide.displacement, jo.SCurve((0.0, 0.5), (0.0, 1e-4)))
        return jo.Mechanism(bar, wall, slide, pull)

    limits = [DisplacementLimit("bar", 1e-3, "end", relative_to="start")]
    with pytest.raises(InputError, match="rigid machine: does not run: .*machine='flexible'"):
        optimise(swing(stretched, limits), machine="rigid")
