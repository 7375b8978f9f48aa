"""The adviser: what it proposes is enough, one mode less is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from jousto.base.errors import InputError
from jousto.certificate.advice import advise
from jousto.certificate.basis_families import family_of, frequency_errors, spectrum
from jousto.certificate.certify import full_model
from jousto.materials.material import Material
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.reduction.files import cache
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.reduction.sparse import factor
from jousto.reduction.stages import Run
from jousto.sections.section import Rectangle
from mesh.blocks import block
from reduction.bodies import STEEL, bent, lattice, pendulum, without_points

ENDS = ("start", "end")


def rod(elements: int = 12) -> Part:
    return Part.beam(1.0, Rectangle(0.02, 0.03), elements, STEEL, name="rod")


def frequency_error(part: Part, modes: int, limit: float, interfaces: tuple[str, ...]) -> float:
    """Worst error of the frequencies up to a limit, those of equal rank compared."""
    full = reduce(part, FreeFree(frequency_limit=limit)).frequencies
    found = reduce(part, CraigBampton(interfaces, modes=modes)).frequencies[: len(full)]
    return float(np.abs(found / full - 1.0).max()) if len(found) == len(full) else 1.0


@pytest.mark.parametrize(("part", "limit"), [(rod(), 500.0), (bent(), 200.0), (bent(), 60.0)])
def test_the_modes_proposed_meet_every_frequency_and_one_less_does_not(
    part: Part, limit: float
) -> None:
    advice = advise(part, ENDS, frequency_limit=limit)
    assert isinstance(advice.method, CraigBampton) and advice.reached
    k = advice.method.modes
    assert k is not None
    assert frequency_error(part, k, limit, ENDS) <= 0.01
    held = reduce(part, CraigBampton(ENDS, frequency_limit=limit))
    fixed = held.n - 6
    # one less leaves a frequency out, free or held
    assert frequency_error(part, k - 1, limit, ENDS) > 0.01 or k == fixed


def test_a_body_that_is_held_vibrates_below_its_free_frequencies() -> None:
    """Clamped at its start the rod has two modes below its first free one."""
    part = rod()
    advice = advise(part, ("start",), frequency_limit=50.0)
    text = str(advice)
    assert "has no elastic mode up to 50 Hz: its lowest, 106.2 Hz, is used instead." in text
    assert "Fixed at start it has 2 modes up to the limit, from 16.71 Hz." in text
    assert isinstance(advice.method, CraigBampton) and advice.method.modes is not None
    assert advice.method.modes >= 2
    for limit in (10.0, 2.0):
        rigid = str(advise(part, ("start",), frequency_limit=limit))
        assert "is used instead; a RigidBody may be enough" in rigid


def test_a_finer_accuracy_takes_more_modes() -> None:
    counts = [
        advise(bent(elements=8), ENDS, frequency_limit=150.0, accuracy=a).method.modes
        for a in (0.05, 0.01, 0.001)
    ]
    assert counts == sorted(counts) and counts[0] < counts[-1]


def test_the_table_shows_what_reduce_gives() -> None:
    part = rod()
    advice = advise(part, ENDS, frequency_limit=500.0)
    rows = {int(row[0].split()[0]): row for row in advice.table.rows[1:]}
    for k, row in rows.items():
        assert reduce(part, CraigBampton(ENDS, modes=k)).n == int(row[2])
    # per cents; the estimate is of the first order in an error
    shown = {k: float(row[3].split()[0]) for k, row in rows.items() if row[3] != "missing"}
    error = {k: 100.0 * frequency_error(part, k, 500.0, ENDS) for k in shown}
    small = [k for k in shown if error[k] < 5.0]
    assert len(small) >= 2
    assert [shown[k] for k in small] == pytest.approx([error[k] for k in small], rel=0.05)


def middle_force(part: Part) -> np.ndarray:
    f = np.zeros((len(part.nodes), 6))
    f[len(part.nodes) // 2, 1] = 1.0
    return f.ravel()


def test_static_error_of_a_load_is_that_of_the_modal_series() -> None:
    """Clamped-clamped beam, force in the middle: the first mode leaves 1 - F^2 / (w^2 d) of d.

    The shares of the modes at the middle, (phi_j(L/2)^2 / w_j^2) / (L^3 / (192 E I)), of the
    symmetric modes l = 4.730041, 10.995608: 0.9674, 0.0260 (Blevins 1979, table 8-1).
    """
    part = Part.beam(1.0, Rectangle(0.004, 0.006), 24, STEEL)
    advice = advise(part, ENDS, loads={"middle": middle_force(part)}, accuracy=1e-3)
    rows = {int(row[0].split()[0]): row for row in advice.table.rows}
    shares = []
    for x in (4.730041, 10.995608):
        s = (np.cosh(x) - np.cos(x)) / (np.sinh(x) - np.sin(x))
        phi = np.cosh(x / 2) - np.cos(x / 2) - s * (np.sinh(x / 2) - np.sin(x / 2))
        shares.append(192.0 * phi**2 / x**4)
    assert float(rows[1][3].split()[0]) == pytest.approx(100.0 * (1.0 - shares[0]), rel=0.05)
    # modes 3 and 4 of both planes lie before the second symmetric one
    later = float(next(row for k, row in rows.items() if k >= 6)[3].split()[0])
    # two printed digits
    assert later == pytest.approx(100.0 * (1.0 - sum(shares)), abs=0.006)


def test_residual_vectors_where_modes_converge_slowly() -> None:
    part = rod()
    advice = advise(part, ENDS, frequency_limit=500.0, loads=middle_force(part), accuracy=1e-3)
    assert isinstance(advice.method, CraigBampton)
    assert len(advice.method.residuals) == 1
    assert "1 residual vector instead makes the static response exact" in str(advice)
    # and it does: displacement in the middle of the clamped beam
    reduced = reduce(part, advice.method)
    assert reduced.rotations is not None
    X = np.concatenate([reduced.modes, reduced.rotations], axis=1).reshape(-1, reduced.n)
    f = middle_force(part)
    K = part.K.toarray()[6:-6, 6:-6]
    exact = f[6:-6] @ np.linalg.solve(K, f[6:-6])
    R = part.rigid_modes()
    Z = np.concatenate([R, X], axis=1)
    ends = Z[np.r_[0:6, len(Z) - 6 : len(Z)]]
    N = np.linalg.svd(ends / np.abs(ends).max(axis=0))[2][12:].T / np.abs(ends).max(axis=0)[:, None]
    S = Z @ N
    found = (S.T @ f) @ np.linalg.solve(S.T @ (part.K @ S), S.T @ f)
    assert found == pytest.approx(exact, rel=1e-6)


def test_stress_needs_more_modes_than_displacement() -> None:
    part = rod()
    loads = {"middle": middle_force(part)}
    with_stress = advise(part, ENDS, loads=loads, accuracy=0.05)
    without = advise(replace(part, stress=None), ENDS, loads=loads, accuracy=0.05)
    assert "middle: stress" in with_stress.table.columns
    assert "middle: stress" not in without.table.columns
    assert "the part has no stress data to compare" in str(without)


def test_without_interfaces() -> None:
    advice = advise(bent(), frequency_limit=100.0)
    assert advice.method == FreeFree(modes=4)
    assert "on the part, give their nodes as interfaces" in str(advice)
    with pytest.raises(InputError, match=r"17.37 Hz, lies above the frequency limit 5 Hz: a Rigid"):
        advise(bent(), frequency_limit=5.0)


def test_small_parts_and_matrices() -> None:
    advice = advise(without_points(pendulum()), "start", frequency_limit=4.0)
    assert isinstance(advice.method, CraigBampton)
    part = lattice()
    f = np.zeros(48)
    f[45:] = 1.0
    assert advise(part, "foot", loads=f, accuracy=0.1).reached


def test_what_cannot_be_advised() -> None:
    part = rod()
    with pytest.raises(InputError) as error:
        advise(part, ENDS, accuracy=2.0)
    assert "give frequency_limit=Hz or loads=patterns" in str(error.value)
    assert "accuracy is 2, must be between 0 and 1" in str(error.value)
    with pytest.raises(InputError, match="frequency_limit is -1 Hz, must be positive"):
        advise(part, ENDS, frequency_limit=-1.0)
    with pytest.raises(InputError, match=r"tip has shape \(3,\), must be \(78\)"):
        advise(part, ENDS, loads={"tip": np.ones(3)})
    with pytest.raises(InputError, match="load 2 is zero everywhere"):
        advise(part, ENDS, loads=np.eye(78)[:, :2] * [1.0, 0.0])
    with pytest.raises(InputError, match="loads need interfaces that fix the part"):
        advise(part, loads=np.ones(78))
    with pytest.raises(InputError, match="no node set 'strat'; did you mean 'start'"):
        advise(part, ("strat",), frequency_limit=100.0)
    with pytest.raises(InputError, match="must be a Part such as"):
        advise(3, frequency_limit=1.0)  # type: ignore[arg-type]
    many = replace(rod(110), node_sets={"all": tuple(range(101))})
    with pytest.raises(
        InputError, match="606 degrees of freedom, each of which becomes a mode: tie"
    ):
        advise(many, "all", frequency_limit=100.0)
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    line = Part.beam(1.0, Rectangle(0.1, 0.1), 2, steel, lumped=True, rotary_inertia=False)
    with pytest.raises(InputError, match="all mass lies on a line"):
        advise(line, ("start",), frequency_limit=1.0)


def test_tied_interfaces_of_the_part_count_if_none_is_named() -> None:
    mesh = block("hexahedron20", (6, 1, 1), (0.6, 0.03, 0.04))
    part = Part.solid(
        mesh,
        STEEL,
        interfaces=(
            Interface("left", mesh.box((-1, -1, -1), (1e-9, 1, 1))),
            Interface("right", mesh.box((0.6 - 1e-9, -1, -1), (1, 1, 1)), kind="average"),
        ),
    )
    f = np.zeros((len(part.nodes), 3))
    f[mesh.nearest((0.3, 0.015, 0.04))[0], 2] = 1.0
    advice = advise(part, frequency_limit=1500.0, loads={"mid fz": f.ravel()}, accuracy=0.02)
    assert isinstance(advice.method, CraigBampton) and advice.reached
    assert advice.method.interfaces == ("left", "right")
    assert advice.method.modes is not None
    full = reduce(part, FreeFree(frequency_limit=1500.0)).frequencies
    found = reduce(part, advice.method).frequencies[: len(full)]
    np.testing.assert_allclose(found, full, rtol=0.02)
    # what the table says of the displacement is what a supported full model gives
    stress = [float(row[5].split()[0]) for row in advice.table.rows if row[5] != "missing"]
    assert stress == sorted(stress, reverse=True)


def test_a_load_on_an_interface_needs_nothing() -> None:
    part = rod()
    f = np.zeros((len(part.nodes), 6))
    f[-1, 1] = 1.0
    advice = advise(part, ENDS, frequency_limit=500.0, loads={"end fy": f.ravel()})
    assert isinstance(advice.method, CraigBampton) and not advice.method.residuals
    assert {row[4] for row in advice.table.rows} == {"0 %"}
    assert "reproduced within 1 % with 0 modes" in str(advice)


def test_modes_below_the_limit_of_the_held_body_are_kept_whatever_the_accuracy() -> None:
    """Constraint modes alone meet the free mode of 106.2 Hz to 49 %, not the held one of 106.0."""
    advice = advise(rod(), ENDS, frequency_limit=110.0, accuracy=0.6)
    assert isinstance(advice.method, CraigBampton) and advice.method.modes == 1


def test_equal_frequencies_of_two_planes_both_count() -> None:
    """A square bar: a mode of one plane has the frequency of the other plane, not its shape."""
    part = Part.beam(1.0, Rectangle(0.02, 0.02), 12, STEEL)
    advice = advise(part, ("start",), frequency_limit=120.0)
    assert isinstance(advice.method, CraigBampton) and advice.method.modes is not None
    assert frequency_error(part, advice.method.modes, 120.0, ("start",)) <= 0.01


def test_the_solver_asked_for_factorises_and_nothing_is_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    part = rod()
    monkeypatch.setenv("JOUSTO_CACHE", str(tmp_path))
    monkeypatch.setattr(cache, "AUTOMATIC", 1)
    asked = []
    original = factor.factorise

    def noted(*args: Any, **kwargs: Any) -> Any:
        asked.append(kwargs["solver"])
        return original(*args, **kwargs)

    monkeypatch.setattr(factor, "factorise", noted)
    advise(part, ENDS, frequency_limit=500.0, solver="superlu")
    assert len(asked) >= 2 and set(asked) == {"superlu"}
    assert not list(tmp_path.iterdir())
    with pytest.raises(InputError, match="no solver 'mumps'"):
        advise(part, ENDS, frequency_limit=500.0, solver="mumps")


def test_a_mode_of_which_the_bases_contain_half_is_missing_whatever_its_frequency() -> None:
    """Half of its mass moves orthogonally to the family, which has its frequency."""
    full, _ = full_model(rod(30), modes=0)
    assert full is not None and full.rigid is not None
    family = family_of(full, ENDS, 300.0, Run())
    B = np.concatenate([full.rigid.R, family.modes.X], axis=1)
    x = np.random.default_rng(3).standard_normal(len(B))
    x -= B @ (B.T @ (full.M @ x))
    f, z = spectrum(family, family.fixed.shape[1])
    first = family.motions(z[:, :1])
    assert frequency_errors(family, (f[:1], first))[-1] < 1e-9
    both = np.sqrt(0.5) * (first + (x / np.sqrt(x @ (full.M @ x)))[:, None])
    assert (frequency_errors(family, (f[:1], both)) == 1.0).all()
