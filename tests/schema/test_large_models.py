"""The work for a model grows with its bodies, not with their square."""

import cProfile
import gc
import pstats
import warnings

import numpy as np
import pytest

import jousto as jo
from jousto.certificate.doctor import doctor
from jousto.model.native.native import Engine
from jousto.schema.file.document import parse_document
from jousto.schema.read import build_model, parse_model
from jousto.schema.summary import model_facts

BODY = "{{name: l{0}, mass: 1 kg, inertia: [1, 1, 1], position: [{1}, 0, 0], markers: {2}}}"
ENDS = "{a: [-0.5, 0, 0], b: [0.5, 0, 0]}"


def hinged(i, carrier):
    return f"  - {{type: revolute, name: j{i}, a: {carrier}, b: l{i}.a, axis: [0, 1, 0]}}"


def loose(n):
    """Bodies without a joint, each of which is warned of."""
    return ["bodies:", *("  - " + BODY.format(i, i, "{}") for i in range(n))]


def chain(n):
    bodies = [f"  - {BODY.format(i, i + 0.5, ENDS)}" for i in range(n)]
    joints = [hinged(i, f"l{i - 1}.b" if i else "ground.origin") for i in range(n)]
    return ["bodies:", *bodies, "joints:", *joints]


def star(n):
    bodies = [f"  - {BODY.format(i, 0.5, ENDS)}" for i in range(n)]
    return ["bodies:", *bodies, "joints:", *(hinged(i, "ground.origin") for i in range(n))]


def busy(n):
    """A chain whose every joint is sprung, driven or rubs, is measured and watched."""
    springs, drives, frictions, sensors, events = [], [], [], [], []
    for i in range(n):
        angle = f"coordinate: j{i}.angle"
        springs.append(f"  - {{type: spring, name: s{i}, {angle}, stiffness: 10, damping: 1}}")
        signal = "{type: s-curve, times: [0, 1 s], values: [0, 0.1]}"
        if i % 2:
            drives.append(f"  - {{type: drive, name: d{i}, {angle}, signal: {signal}}}")
        else:
            law = "radius: 1 mm, law: {type: stick-slip}"
            frictions.append(f"  - {{name: f{i}, joint: j{i}, mu_kinetic: 0.1, {law}}}")
        sensors.append(f"  - {{type: coordinate, name: c{i}, {angle}}}")
        sensors.append(f"  - {{type: force, name: r{i}, force: s{i}}}")
        events.append(f"  - {{name: e{i}, watch: c{i}, threshold: 2 rad}}")
        events.append(f"  - {{name: w{i}, watch: j{i}.angle, threshold: 3 rad}}")
    lists = {
        "couplings": drives,
        "forces": springs,
        "frictions": frictions,
        "sensors": sensors,
        "events": events,
    }
    return [*chain(n), *(line for key, lines in lists.items() for line in (f"{key}:", *lines))]


def examine(text):
    file = parse_model(text)
    model_facts(file)
    doctor(jo.compile(file.mechanism)).lines()


def calls(job, *args):
    """Return how often functions were called, those of the interpreter and of NumPy included."""
    profile = cProfile.Profile()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        profile.runcall(job, *args)
    return sum(each[1] for each in pstats.Stats(profile).stats.values())


def hub(n):
    """Bodies that hang on one moving body."""
    points = ", ".join(f"p{i}: [{i}, 0, 0]" for i in range(n))
    middle = f"  - {{name: hub, mass: 9 kg, inertia: [1, 1, 1], markers: {{{points}}}}}"
    bodies = [f"  - {BODY.format(i, i + 0.5, ENDS)}" for i in range(n)]
    return ["bodies:", middle, *bodies, "joints:", *(hinged(i, f"hub.p{i}") for i in range(n))]


def tree(n):
    """Each body carries two others."""
    bodies = [f"  - {BODY.format(i, (i + 1).bit_length() - 0.5, ENDS)}" for i in range(n)]
    joints = [hinged(i, f"l{(i - 1) // 2}.b" if i else "ground.origin") for i in range(n)]
    return ["bodies:", *bodies, "joints:", *joints]


def loops(n):
    """Pairs of bodies from the ground to the ground, each a loop without redundant rows."""
    bodies, joints = ["bodies:"], ["joints:"]
    joint = "  - {{type: {}, name: {}{}, a: {}, b: {}}}"
    for i in range(n):
        bodies += [
            f"  - {BODY.format(f'a{i}', 0.5, ENDS)}",
            f"  - {BODY.format(f'b{i}', 1.5, ENDS)}",
        ]
        joints.append(joint.format("revolute", "r", i, "ground.origin", f"la{i}.a"))
        joints.append(joint.format("spherical", "s", i, f"la{i}.b", f"lb{i}.a"))
        joints.append(joint.format("point-on-line", "p", i, "ground.origin", f"lb{i}.b"))
    joints = [x.replace("}", ", axis: [1, 0, 0]}") if "line" in x else x for x in joints]
    return [*bodies, *joints]


ROD = """\
parts:
  rod:
    type: frame
    nodes: [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]]
    elements: [[0, 1], [1, 2]]
    sections: {type: rectangle, width: 100 mm, height: 100 mm}
    materials: S355
    reduce: {type: craig-bampton, interfaces: [node1, node3], modes: 2}"""


def elastic(n):
    """A chain of bodies of one flexible part."""
    bodies = [f"  - {{name: l{i}, part: rod, position: [{i}, 0, 0]}}" for i in range(n)]
    joint = "  - {{type: revolute, name: j{}, a: {}, b: l{}.node1, axis: [0, 1, 0]}}"
    ends = ["ground.origin", *(f"l{i}.node3" for i in range(n))]
    joints = [joint.format(i, ends[i], i) for i in range(n)]
    return [ROD, "bodies:", *bodies, "joints:", *joints]


@pytest.mark.parametrize(
    ("machine", "n"),
    [(loose, 210), (star, 210), (busy, 70), (hub, 210), (chain, 210), (tree, 210), (loops, 140)]
    + [(elastic, 40)],
)
def test_work_grows_with_the_bodies(machine, n):
    """Twice the bodies, twice the further calls: 2 for linear work, 4 for pairs of bodies.

    2.1 leaves a part of 5 % to what grows with the logarithm, such as heaps, and to the sizes at
    which dense matrices are left for sparse ones.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        examine("\n".join(machine(4)))  # loads modules
    one, two, four = (calls(examine, "\n".join(machine(k * n))) for k in (1, 2, 4))
    assert (four - two) / (two - one) < 2.1


@pytest.mark.parametrize("machine", [chain, tree])
def test_a_body_costs_the_same_among_few_and_many(machine):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        examine("\n".join(machine(4)))  # loads modules
    cost = {}
    for n in (200, 2000):
        cost[n] = calls(examine, "\n".join(machine(n))) / n
    assert abs(cost[2000] / cost[200] - 1.0) < 0.1


class Counted(np.ndarray):
    """An array that counts the numbers that functions of NumPy take from it."""

    numbers = 0

    def __array_ufunc__(self, function, method, *inputs, **options):
        plain = [x.view(np.ndarray) if isinstance(x, Counted) else x for x in inputs]
        found = getattr(function, method)(*plain, **options)
        Counted.numbers += max(np.size(x) for x in plain)
        return found.view(Counted) if isinstance(found, np.ndarray) else found


def test_closed_joints_are_looked_at_once(monkeypatch):
    """Twice the joints, twice the rows that are compared: each was compared for every joint."""
    residuals = Engine.constraints
    monkeypatch.setattr(
        Engine, "constraints", lambda self: tuple(x.view(Counted) for x in residuals(self))
    )
    counts = []
    for n in (60, 120):
        machine = parse_model("\n".join(chain(n))).mechanism
        Counted.numbers = 0
        jo.compile(machine)
        counts.append(Counted.numbers)
    assert 5 * 60 <= counts[0]  # five rows a hinge
    assert counts[1] < 2.1 * counts[0]


# calls of functions for a hinged body in Python 3.11 with NumPy 2, those of both included: 230 for
# its text, 550 for its objects, 280 to compile, 20 to examine it
FEW = 1100


def test_a_hinged_body_costs_few_calls():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        examine("\n".join(chain(4)))  # loads modules
    one, two = (calls(examine, "\n".join(chain(n))) for n in (300, 600))
    assert (two - one) / 300 < FEW


def test_reading_and_compiling_do_not_look_for_garbage():
    """They keep what they make; each look at all of it takes longer than the one before."""
    text = "\n".join(chain(300))
    examine(text)  # loads modules
    seen = []
    gc.collect()
    gc.callbacks.append(lambda phase, info: seen.append(phase) if phase == "start" else None)
    looks = []
    try:
        found = text
        for stage in (parse_document, lambda d: build_model(d).mechanism, jo.compile, doctor):
            seen.clear()
            found = stage(found)
            looks.append(len(seen))
    finally:
        gc.callbacks.pop()
    assert gc.isenabled()
    assert max(looks) <= 1  # when they are through


def test_a_file_that_was_read_leaves_no_garbage():
    """What refers to one another stays until a search through all objects finds it."""
    text = "\n".join(chain(30))
    parse_model(text)  # loads modules
    gc.collect()
    parse_model(text)
    assert gc.collect() == 0
