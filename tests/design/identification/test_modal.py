"""Modal data: pairing, two masses with closed form, and a fork of another program."""

import dataclasses

import numpy as np
import pytest

import jousto as jo
from design.identification.machines import DATA
from jousto.design import Modal, identify, mac, read_modes
from jousto.design.identification.mode_pairs import pair_modes


def row(k, m2):
    """Return two masses in a row on two springs k: a first of 1 kg, a second m2."""
    a = jo.RigidBody("a", 1.0, (1.0, 1.0, 1.0))
    b = jo.RigidBody("b", m2, (1.0, 1.0, 1.0), position=(0.5, 0.0, 0.0))
    first = jo.Prismatic("first", jo.ground["origin"], a["origin"], axis=(1, 0, 0))
    second = jo.Prismatic("second", a.at((0.5, 0, 0)), b["origin"], axis=(1, 0, 0))
    return jo.Mechanism(
        a,
        b,
        first,
        second,
        jo.Spring("k1", first.displacement, k),
        jo.Spring("k2", second.displacement, k),
    )


def exact(k, m2):
    """Return frequencies, Hz, and shapes of the two masses."""
    values, vectors = np.linalg.eig(np.array([[2 * k, -k], [-k / m2, k / m2]]))
    order = np.argsort(values)
    return np.sqrt(values[order]) / (2 * np.pi), vectors.T[order]


def test_frequencies_and_shapes_of_two_masses():
    f, shapes = exact(900.0, 2.5)
    data = Modal(
        f,
        shapes * np.array([[-3.0], [0.2]]),
        places=[(0, 0, 0), (0.5, 0, 0)],
        directions=[(1, 0, 0), (2, 0, 0)],
    )
    found = identify(
        row,
        [jo.Parameter("k", 500.0, unit="N/m"), jo.Parameter("m2", 1.0, unit="kg")],
        data,
    )
    assert found["k"] == pytest.approx(900.0, rel=1e-7)
    assert found["m2"] == pytest.approx(2.5, rel=1e-7)
    # 2 frequencies and 2 shapes of 2 values with a scale each, 2 unknowns
    assert found.dof == 2


def test_deviation_of_a_stiffness_from_one_frequency():
    f, _ = exact(900.0, 2.5)
    found = identify(lambda k: row(k, 2.5), jo.Parameter("k", 500.0, unit="N/m"), Modal(f[:1]))
    # f grows with the root of k
    assert found.sd("k") / found["k"] == pytest.approx(2e-3, rel=1e-4)


def test_modes_are_paired_by_their_shapes():
    """Two modes whose order in frequency is exchanged are recognised by their shapes."""
    shapes = np.array([[1.0, 0.1, 0.0], [0.0, 0.2, 1.0]])
    computed = np.array([[0.0, 0.0, 2.0], [0.5, 0.0, 0.5], [1.0, 0.2, 0.1]])
    found = pair_modes(
        np.array([10.0, 11.0]), shapes, np.array([9.5, 10.4, 11.8]), computed, None, 0
    )
    assert found.frequencies == pytest.approx([11.8, 9.5])
    assert found.mac == pytest.approx(mac(shapes, computed)[[0, 1], [2, 0]])
    scale = (computed[2] @ found.measured[0]) / (computed[2] @ computed[2])
    assert found.shape(0) == pytest.approx(scale * computed[2])


def test_double_modes_are_compared_as_a_space():
    """Shapes of a double frequency may be any combination."""
    c, s = np.cos(0.7), np.sin(0.7)
    measured = np.array([[c, s, 0.0], [-s, c, 0.0]])
    computed = np.eye(3)
    f = np.array([10.0, 10.001])
    found = pair_modes(f, measured, np.array([10.0, 10.0, 20.0]), computed, None, 1e-3)
    assert found.clusters == ((0, 1),)
    assert found.mac == pytest.approx([1.0, 1.0])
    assert found.shape(0) == pytest.approx(found.measured[0])


def test_complex_shapes_are_turned():
    f, shapes = exact(900.0, 2.5)
    turned = shapes * np.exp(1j * np.array([[0.4], [2.0]]))
    places = {"places": [(0, 0, 0), (0.5, 0, 0)], "directions": np.eye(3)[[0, 0]]}
    data = Modal(f, turned, **places)
    assert mac(np.asarray(data.shapes), shapes).diagonal() == pytest.approx([1.0, 1.0])
    with pytest.warns(jo.JoustoWarning, match="shape of mode 1 is complex"):
        Modal(f[:1], [[1.0, 1.0j]], **places)


def test_data_that_is_wrong():
    with pytest.raises(jo.InputError) as caught:
        Modal([1.0, -2.0], [[1.0, 2.0]], damping=[0.1], frequency_noise=0.0)
    text = str(caught.value)
    assert "frequencies must be positive; leave rigid motions out" in text
    assert "shapes have shape (1, 2), must be (2, m)" in text
    assert "damping" in text and "frequency_noise" in text
    with pytest.raises(jo.InputError, match="places are missing"):
        Modal([1.0], [[1.0, 2.0]])
    k = jo.Parameter("k", 500.0, unit="N/m")
    away = Modal([1.0], [[1.0]], places=[(0, 0, 3)], directions=[(1, 0, 0)])
    with pytest.raises(jo.InputError, match="no node within 0.01 m of the place"):
        identify(lambda k: row(k, 1.0), k, away)
    with pytest.raises(jo.InputError, match="the machine has 2 modes, 3 were measured"):
        identify(lambda k: row(k, 1.0), k, Modal([1.0, 2.0, 3.0]))


def test_files_that_are_none(tmp_path):
    with pytest.raises(jo.InputError):
        read_modes(tmp_path / "none.uff")
    other = tmp_path / "other.uff"
    other.write_text("time,x\n0,1\n")
    with pytest.raises(jo.InputError):
        read_modes(other)


def fork(k1, k2, E):
    """Return the steel fork of the data."""
    steel = jo.Material(E=E, nu=0.3, rho=7850.0)
    bar = jo.Part.beam(0.6, jo.Rectangle(0.03, 0.012), 12, steel, name="bar")
    inner = {"left": np.array([4]), "right": np.array([8])}
    bar = dataclasses.replace(bar, node_sets={**bar.node_sets, **inner})
    ends = ("start", "end", "left", "right")
    bar = jo.FlexibleBody("bar", jo.reduce(bar, jo.CraigBampton(ends, modes=39)))
    tine = jo.Part.beam(0.5, jo.Rectangle(0.03, 0.006), 10, steel, name="tine")
    tine = jo.reduce(tine, jo.CraigBampton(("start", "end"), modes=39))
    up = jo.Rotate((0, 1, 0), degrees=-90.0)
    a = jo.FlexibleBody("a", tine, position=(0.2, 0, 0), orientation=up)
    b = jo.FlexibleBody("b", tine, position=(0.4, 0, 0), orientation=up)
    left = jo.Revolute("left", bar["left"], a["start"], axis=(0, 1, 0))
    right = jo.Revolute("right", bar["right"], b["start"], axis=(0, 1, 0))
    return jo.Mechanism(
        bar,
        a,
        b,
        jo.Fixed("start", jo.ground["origin"], bar["start"]),
        jo.Fixed("end", jo.ground.at((0.6, 0, 0)), bar["end"]),
        left,
        right,
        jo.Spring("k1", left.angle, k1),
        jo.Spring("k2", right.angle, k2),
    )


def test_frequencies_of_the_fork_are_those_of_another_program():
    exact = [10.19439, 10.47322, 93.54896, 93.99423, 116.77725, 287.645]
    made = jo.modes(jo.compile(fork(356.0, 331.0, 206.4e9)), count=9).frequencies
    assert made[[0, 1, 4, 5, 6, 7]] == pytest.approx(exact, rel=3e-6)


@pytest.mark.slow
def test_hammer_test_of_the_fork():
    """Best estimates and deviations of an independent fit."""
    found = identify(
        fork,
        [
            jo.Parameter("k1", 600.0, unit="N m/rad"),
            jo.Parameter("k2", 600.0, unit="N m/rad"),
            jo.Parameter("E", 200e9, unit="Pa"),
        ],
        read_modes(DATA / "fork.uff"),
    )
    best = {"k1": (357.082, 0.75), "k2": (330.549, 0.62), "E": (206.711e9, 0.22e9)}
    for name, (value, sd) in best.items():
        assert abs(found[name] - value) < 0.05 * sd, name
        assert found.sd(name) == pytest.approx(sd, rel=0.03), name
    assert found.ratio == pytest.approx(1.0, abs=4 * np.sqrt(2 / found.dof))
