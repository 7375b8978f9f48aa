"""What cannot be reduced, and the sentence that says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from jousto.base.errors import InputError, JoustoWarning
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from reduction.bodies import (
    STEEL,
    bent,
    lattice,
    pendulum,
    turned,
)


def test_supported_stiffness() -> None:
    part = bent()
    K = part.K.tolil()
    K[7, 7] *= 1.001
    with pytest.raises(InputError, match=r"not free: a rigid .* at node2 uy.*Remove supports"):
        reduce(replace(part, K=sp.csr_array(K)), FreeFree(modes=2))


def test_all_mass_on_a_line() -> None:
    part = Part.beam(2.0, Rectangle(0.1, 0.1), 4, STEEL, lumped=True, rotary_inertia=False)
    with pytest.raises(InputError, match=r"on a line along \[1\. 0\. 0\.\].*rotary_inertia=True"):
        reduce(part, CraigBampton(("start",), modes=2))
    Q = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    with pytest.raises(InputError, match="all mass lies on a line"):
        reduce(turned(part, Q, np.array([5.0, 3.0, 1.0])), FreeFree(modes=2))
    helped = Part.beam(
        2.0, Rectangle(0.1, 0.1), 4, STEEL, lumped=True, rotary_inertia=False,
        point_masses=(PointMass("end", 1.0, inertia=(0.01, 0.01, 0.01)),),
    )  # fmt: skip
    assert reduce(helped, CraigBampton(("start",), modes=2)).n == 2


def test_all_mass_at_one_point() -> None:
    part = bent(lumped=True)
    M = np.zeros(part.M.shape)
    M[6:9, 6:9] = np.eye(3)
    part = replace(part, M=sp.csr_array(M), mass_points=None)
    with pytest.raises(InputError, match="all mass lies at one point"):
        reduce(part, FreeFree(modes=1))


def test_mass_almost_on_a_line() -> None:
    with pytest.warns(JoustoWarning, match="almost all mass lies on a line"):
        reduce(pendulum(offset=1e-6), CraigBampton(("start",), modes=4))


def test_more_modes_than_there_are() -> None:
    part = pendulum()
    with pytest.raises(InputError, match=r"13 fixed-interface modes.*only 12.*rotary_inertia=True"):
        reduce(part, CraigBampton(("start",), modes=13))
    # 15 translations with mass less six rigid motions
    assert reduce(part, FreeFree(modes=9)).n == 9
    with pytest.raises(InputError, match=r"10 free-free modes.*only 9"):
        reduce(part, FreeFree(modes=10))


def test_cut_pair_of_equal_frequencies() -> None:
    part = Part.beam(1.0, Rectangle(0.02, 0.02), 6, STEEL)
    with pytest.warns(JoustoWarning, match="fixed-interface modes 3 and 4 have the same frequency"):
        reduce(part, CraigBampton(("start",), modes=3))


def test_unknown_interface() -> None:
    with pytest.raises(InputError) as error:
        reduce(bent(), CraigBampton(("strat", "ned"), modes=1))
    assert "no node set 'strat'; did you mean 'start'?" in str(error.value)
    assert "no node set 'ned'" in str(error.value)
    with pytest.raises(InputError, match="'start' and 'node1' share node1"):
        reduce(bent(), CraigBampton(("start", "node1"), modes=1))


def test_interface_that_does_not_hold_the_body() -> None:
    for name in ("node1", "line"):
        with pytest.raises(InputError, match="does not stop all rigid motions.*at least three"):
            reduce(lattice(), CraigBampton((name,), modes=1))


def test_loose_part_of_the_stiffness() -> None:
    """A node on two bars swings freely: K has more than six zero modes."""
    part = lattice(bars_of_last_node=2)
    with pytest.raises(InputError, match="has a free motion although the body is fixed; node16 u"):
        reduce(part, CraigBampton(("foot",), modes=1))
    with pytest.raises(InputError, match="has a free motion although the body is fixed"):
        reduce(part, FreeFree(modes=1))


def test_negative_mass() -> None:
    part = bent(lumped=True)
    M = part.M.tolil()
    M[24, 24] *= -1.0
    M[25, 25] *= -1.0
    M[26, 26] *= -1.0
    with pytest.raises(InputError, match="not positive semidefinite"):
        reduce(replace(part, M=sp.csr_array(M), mass_points=None), FreeFree(modes=3))


def test_mass_of_a_supported_part() -> None:
    part = bent(lumped=True)
    M = part.M.tolil()
    M[1, 1] = 0.0
    with pytest.raises(InputError, match="mass is not the same in all directions"):
        reduce(replace(part, M=sp.csr_array(M), mass_points=None), FreeFree(modes=3))


def test_nothing_left() -> None:
    with pytest.raises(InputError, match="has no elastic mode.*RigidBody"):
        reduce(bent(), CraigBampton(("start",), modes=0))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: reduce(bent(), CraigBampton(modes=1)), "the method contains none"),
        (lambda: CraigBampton(("a",)), "give modes=number or frequency_limit=Hz"),
        (lambda: CraigBampton(("a", "a"), modes=1), "'a' is named more than once"),
        (lambda: CraigBampton((3,), modes=1), "3 is not the name"),  # type: ignore[arg-type]
        (lambda: CraigBampton(("a",), modes=-1), "modes is -1"),
        (lambda: CraigBampton(("a",), modes=1.5), "modes is 1.5"),  # type: ignore[arg-type]
        (lambda: FreeFree(frequency_limit=float("nan")), "frequency_limit is nan"),
        (lambda: FreeFree(frequency_limit=0.0), "must be positive, in Hz"),
        (lambda: FreeFree(modes=0), "at least 1"),
        (lambda: reduce(bent(), "craig"), "must be CraigBampton"),  # type: ignore[arg-type]
    ],
)
def test_options(make: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()  # type: ignore[operator]
