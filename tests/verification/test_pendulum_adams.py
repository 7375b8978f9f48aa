"""The flexible pendulum of T. Rantalainen 2007 (LUT), chapter 5, against MSC.Adams.

Beam 2 m x 0.1 m x 0.1 m of four Euler-Bernoulli elements with lumped masses, spherical joint at
node 1, released horizontally. Annex 2 prints the height of the middle node by MSC.Adams for 101
instants, with four decimals.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo

DATA = Path(__file__).parent / "data"
# table 1; the caption of figure 12 has a digit swap
FREQUENCIES = np.array([3.5306262013, 14.6039279966])
# the beam of the annex is as soft as rubber; the package asks whether its unit is right
pytestmark = pytest.mark.filterwarnings("ignore:.*softer than most plastics")


def part(E: float) -> jo.Part:
    # the last node is off the line by 1e-5 m, annex 1, so that the axial inertia is not zero
    nodes = [[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1.5, 0, 0], [2, -1e-5, 0]]
    return jo.Part.frame(
        nodes,
        [[0, 1], [1, 2], [2, 3], [3, 4]],
        sections=jo.Rectangle(0.1, 0.1),
        materials=jo.Material(E=E, nu=0.3, rho=7850.0),
        lumped=True,
        rotary_inertia=False,
        theory=jo.parts.EulerBernoulli(),
    )


def computed(E: float = 2.07e8) -> jo.ReducedPart:
    reduced = jo.reduce(part(E), jo.CraigBampton(interfaces=("node1",), modes=4))
    return reduced.keep(reduced.in_plane("xy"))


def printed() -> jo.ReducedPart:
    table = np.genfromtxt(DATA / "pendulum_modes.csv", delimiter=",", names=True)
    X = np.zeros((30, 2))
    for j in (0, 1):
        for dof, name in ((0, "x"), (1, "y"), (5, "rz")):
            X[dof::6, j] = np.nan_to_num(table[f"mode{j + 1}_{name}"])  # illegible: zero
    return jo.reduction.from_modes(part(2.07e8), X, FREQUENCIES)


def pendulum(rod: jo.ReducedPart) -> jo.Model:
    arm = jo.FlexibleBody("arm", rod)
    return jo.compile(
        jo.Mechanism(
            arm,
            jo.Spherical("pivot", jo.ground["origin"], arm["node1"]),
            jo.Gravity((0, -9.81, 0)),
            jo.PositionSensor("middle", arm["node3"]),
        )
    )


def deviation(model: jo.Model, solver: jo.RK4 | jo.ROS2) -> float:
    """Largest distance to the column of MSC.Adams over its 101 rows, m."""
    adams = np.genfromtxt(DATA / "pendulum_adams.csv", delimiter=",", names=True)
    run = jo.simulate(model, 1.0, solver=solver, output_step=0.01)
    assert len(adams) == len(run.time) == 101
    np.testing.assert_allclose(run.time, adams["time_s"], rtol=0, atol=1e-12)
    return float(np.abs(run["middle"][:, 1] - adams["adams_y_m"]).max())


def test_the_frequencies_are_those_of_table_1():
    # 2e-5: what a modal program of single precision may differ by; jousto agrees to 3e-8
    np.testing.assert_allclose(computed().frequencies, FREQUENCIES, rtol=2e-5)


def test_the_modulus_printed_in_table_1_misses_its_frequencies():
    # frequencies grow with sqrt(E): sqrt(2.08 / 2.07) - 1 = 0.241 %
    miss = computed(2.08e8).frequencies / FREQUENCIES - 1
    np.testing.assert_allclose(miss, np.sqrt(2.08 / 2.07) - 1, atol=2e-5)
    assert np.all(np.round(100 * miss, 2) == 0.24)


# four decimals round to 5e-5 m; 5.6e-5 leaves a tenth of that for the difference of two programs
@pytest.mark.parametrize("rod", [computed, printed], ids=["computed modes", "printed modes"])
def test_rk4_reproduces_every_row_of_msc_adams(rod):
    assert deviation(pendulum(rod()), jo.RK4(step=1e-3)) < 5.6e-5


def test_ros2_reproduces_every_row_of_msc_adams():
    # its own error at this step is 2e-6 m, second order
    assert deviation(pendulum(computed()), jo.ROS2(step=1e-3)) < 5.6e-5


def test_msc_adams_decides_for_the_modulus_of_the_annex():
    # 0.24 % in frequency moves the middle node by 0.47 mm, nine times the rounding of the table
    assert deviation(pendulum(computed(2.08e8)), jo.RK4(step=1e-3)) > 4e-4
