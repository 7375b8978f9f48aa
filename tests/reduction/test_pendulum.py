"""The pendulum of T. Rantalainen 2007 (LUT), chapter 5: published frequencies and mode shapes."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.base.errors import JoustoWarning
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import from_modes, reduce
from reduction.bodies import dofs, pendulum

# Table 1; the modulus printed there (2.08e8) does not give them, that of annex 1 (2.07e8) does
FREQUENCIES = np.array([3.5306262013, 14.6039279966])

# Table 2: x, y and rotation about z of both modes at the five nodes; mode 2's x is illegible
MODE_1 = np.array(
    [
        [-3.85208e-06, 0.131667092, -0.336220543],
        [-3.78477e-06, -0.023031338, -0.245333069],
        [-3.7178e-06, -0.087024389, 0.005403929],
        [-3.6515e-06, -0.020191389, 0.240757044],
        [2.61602e-05, 0.128827139, 0.326677061],
    ]
)
MODE_2 = np.array(
    [
        [0.099867928, -1.241869937],
        [-0.110643051, 0.145251329],
        [0.033526027, 0.262813214],
        [0.065141232, -0.14179849],
        [-0.075916347, -0.35227349],
    ]
)


def in_plane(part: Part) -> ReducedPart:
    """Two bending modes in each plane, then those in the plane of motion."""
    reduced = reduce(part, CraigBampton(interfaces=("start",), modes=4))
    assert reduced.n == 4
    return reduced.keep(reduced.in_plane("xy"))


def test_frequencies() -> None:
    # ten digits are printed; the macro's offset of the last node accounts for the rest
    assert in_plane(pendulum()).frequencies == pytest.approx(FREQUENCIES, rel=1e-7)


def test_the_printed_modulus_misses() -> None:
    ratio = in_plane(pendulum(E=2.08e8)).frequencies / FREQUENCIES
    assert ratio - 1.0 == pytest.approx([0.00241, 0.00241], abs=2e-5)


def test_the_printed_digits_belong_to_an_offset_of_a_tenth_of_a_millimetre() -> None:
    # annex 1 says 1e-5 m, but with 1e-4 m all printed digits agree, and so do the x translations
    reduced = in_plane(pendulum(offset=1e-4))
    assert reduced.frequencies == pytest.approx(FREQUENCIES, rel=2e-11)
    sign = np.sign(reduced.modes[0, 1, 0])
    assert sign * reduced.modes[:, 0, 0] == pytest.approx(MODE_1[:, 0], rel=3e-6)


@pytest.mark.parametrize("mode", [0, 1])
def test_mode_shapes(mode: int) -> None:
    reduced = in_plane(pendulum())
    table = (MODE_1[:, 1:], MODE_2)[mode]
    computed = np.column_stack([reduced.modes[:, 1, mode], reduced.rotations[:, 2, mode]])
    sign = np.sign(computed[0, 0] * table[0, 0])
    assert sign * computed == pytest.approx(table, abs=2e-7)


def test_table_as_given_modes() -> None:
    part = pendulum()
    modes = np.zeros((5, 6, 2))
    modes[:, [0, 1, 5], 0] = MODE_1
    modes[:, [1, 5], 1] = MODE_2
    reduced = from_modes(part, modes.reshape(30, 2), FREQUENCIES)
    assert reduced.invariants.I6 == pytest.approx(np.eye(2), abs=1e-6)
    assert reduced.frequencies == pytest.approx(FREQUENCIES)
    assert reduced.in_plane("xy") == (0, 1)
    assert dofs(reduced.modes, reduced.rotations) == pytest.approx(modes.reshape(30, 2), abs=0.0)


def test_given_modes_must_be_mass_orthonormal() -> None:
    modes = np.zeros((5, 6, 1))
    modes[:, 1, 0] = MODE_1[:, 1] * 1.01
    with pytest.warns(JoustoWarning, match=r"not mass-orthonormal.*mode 0.*off by 0\.02"):
        from_modes(pendulum(), modes.reshape(30, 1), FREQUENCIES[:1])
