"""Strain life: notch rules, material memory, loops and lives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

import jousto as jo
from jousto.fatigue.cycles.rainflow import turning_points
from jousto.fatigue.local.strain_life import loops

NAMES = jo.fatigue.strain_lives()


@pytest.mark.parametrize("name", NAMES)
def test_life_and_amplitude_are_inverse(name: str) -> None:
    m = jo.fatigue.strain_life(name)
    N = np.logspace(1, 9, 9)
    for mean in (0.0, -100e6, 0.2 * m.sf):
        e = m.amplitude(N, mean)
        assert m.cycles(e, mean=mean, form="morrow") == pytest.approx(N, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_cyclic_curve_and_its_inverse(name: str) -> None:
    m = jo.fatigue.strain_life(name)
    s = np.linspace(-800e6, 800e6, 9)
    assert m.stress(m.strain(s)) == pytest.approx(s, rel=1e-10, abs=1e-3)
    assert m.strain(-s) == pytest.approx(-m.strain(s), rel=1e-14)


def test_the_forms_agree_where_there_is_no_mean_stress() -> None:
    # with K' and n' from the strain-life constants SWT at R = -1 is Coffin-Manson
    m = jo.fatigue.strain_life("rqc-100-sae")
    e = np.array([8e-4, 2e-3, 1e-2])
    assert m.cycles(e, form="swt") == pytest.approx(m.cycles(e), rel=1e-9)
    assert m.cycles(e, form="morrow") == pytest.approx(m.cycles(e), rel=1e-12)


def test_transition_life() -> None:
    m = jo.fatigue.strain_life("aisi-4340")
    x = 2.0 * m.transition
    assert m.sf / m.E * x**m.b == pytest.approx(m.ef * x**m.c, rel=1e-12)


def test_limits_of_life() -> None:
    m = jo.fatigue.strain_life("sae-1045")
    assert m.cycles(0.0) == np.inf
    assert m.cycles(1e-3, mean=-2e9, form="swt") == np.inf
    assert m.cycles(1e-3, mean=1.1 * m.sf, form="morrow") == 0.0
    # tension shortens, compression lengthens a life
    for form in ("morrow", "swt"):
        lives = [float(m.cycles(2e-3, mean=s, form=form)) for s in (-100e6, 0.0, 100e6)]
        assert lives[0] > lives[1] > lives[2]


def test_uniform_material_law() -> None:
    # Baeumel and Seeger 1990; endurance limit of unalloyed steel 0.45 S_u at 2e6 cycles is known
    m = jo.fatigue.StrainLife.uniform(500e6, 206e9)
    assert (m.sf, m.b, m.ef, m.c) == pytest.approx((750e6, -0.087, 0.59, -0.58))
    assert m.hardening == pytest.approx((825e6, 0.15))
    assert jo.fatigue.StrainLife.uniform(1000e6, 206e9).ef == pytest.approx(
        0.59 * (1.375 - 125.0 * 1000 / 206e3)
    )
    light = jo.fatigue.StrainLife.uniform(400e6, 70e9, metal="light")
    assert (light.sf, light.b, light.ef, light.c) == pytest.approx((668e6, -0.095, 0.35, -0.69))


@pytest.mark.parametrize("name", ["sae-1045", "rqc-100", "aisi-4340"])
def test_notch_rules_meet_their_equations(name: str) -> None:
    m = jo.fatigue.strain_life(name)
    K, n = m.hardening
    S = np.array([-1500e6, -300e6, 0.0, 50e6, 700e6, 3000e6])
    s, e = jo.fatigue.neuber(S, m)
    assert s * e == pytest.approx(S**2 / m.E, rel=1e-10)
    assert e == pytest.approx(m.strain(s))
    g, eg = jo.fatigue.glinka(S, m)
    # energy under the cyclic curve, by quadrature
    for stress, elastic in zip(np.abs(g), S, strict=True):
        x = np.linspace(0.0, stress, 20001)
        slope = 1.0 / m.E + np.where(x > 0, (x / K) ** (1 / n - 1), 0.0) / (n * K)
        energy = np.trapezoid(x * slope, x)
        assert energy == pytest.approx(elastic**2 / (2 * m.E), rel=1e-5, abs=1e-9)
    # Glinka's strain is never above Neuber's
    assert np.all(np.abs(eg) <= np.abs(e) * (1 + 1e-12))


def test_neuber_against_pylife() -> None:
    # pyLife's extended rule with a limit load ratio so large that the nominal plastic strain goes
    law = pytest.importorskip("pylife.materiallaws.notch_approximation_law")
    m = jo.fatigue.strain_life("sae-1045")
    K, n = m.hardening
    other = law.ExtendedNeuber(E=m.E, K=K, n=n, K_p=1e9)
    for S in (200e6, 600e6, 1200e6):
        s, e = jo.fatigue.neuber(S, m)
        assert float(np.ravel(other.stress(S))[0]) == pytest.approx(float(s), rel=1e-4)


def test_masing_and_memory() -> None:
    # 0 -> 700 -> -700 -> 700: symmetric loop; an inner loop leaves the outer one as it was
    m = jo.fatigue.strain_life("sae-1045")
    outer = jo.fatigue.local_path([0, 700e6, -700e6, 700e6], m)
    assert outer.stress[2] == pytest.approx(-outer.stress[1], rel=1e-12)
    assert outer.stress[3] == pytest.approx(outer.stress[1], rel=1e-12)
    inner = jo.fatigue.local_path([0, 700e6, -200e6, 300e6, -700e6, 700e6], m)
    assert inner.stress[[1, 4, 5]] == pytest.approx(outer.stress[1:], rel=1e-12)
    assert inner.strain[[1, 4, 5]] == pytest.approx(outer.strain[1:], rel=1e-12)
    # the branch down from 700 by 900 is the cyclic curve doubled
    s, e = jo.fatigue.neuber(450e6, m)
    assert inner.stress[1] - inner.stress[2] == pytest.approx(2 * s, rel=1e-12)
    assert inner.strain[1] - inner.strain[2] == pytest.approx(2 * e, rel=1e-12)
    # an overload leaves compression behind: the same small cycle has another mean stress
    small = [300e6, 0.0, 300e6]
    before = jo.fatigue.local_cycles([0, *small], m, residue="half")
    after = jo.fatigue.local_cycles([0, 1200e6, 0.0, *small], m, residue="half")
    assert before.mean.max() > 0.0
    assert after.mean[after.count == 1.0].min() < -90e6


def test_low_stress_is_elastic() -> None:
    m = jo.fatigue.strain_life("aisi-4340")
    path = jo.fatigue.local_path([0, 50e6, -20e6, 40e6, -60e6], m)
    assert path.stress == pytest.approx(path.elastic, rel=1e-6)
    assert path.strain == pytest.approx(path.elastic / m.E, rel=1e-6)


def test_memory_against_a_chain_of_friction_elements() -> None:
    # Iwan's parallel spring-slider chain obeys Masing and memory by construction: piecewise linear
    # cyclic curve through the same points, driven by the strains of the path
    m = jo.fatigue.strain_life("sae-1045")
    rng = np.random.default_rng(3)
    S = rng.uniform(-900e6, 900e6, 60)
    path = jo.fatigue.local_path(S, m)
    limit = 1.05 * np.abs(path.strain).max()
    e = np.linspace(0.0, limit, 3001)
    s = m.stress(e)
    slope = np.diff(s) / np.diff(e)
    k = -np.diff(np.append(slope, 0.0))  # stiffness of the slider that yields at e[1:]
    slip = np.zeros_like(k)
    stress = []
    for strain in path.strain:
        slip += np.clip(strain - slip, None, -e[1:]) + e[1:]  # slips in compression
        slip += np.clip(strain - slip, e[1:], None) - e[1:]  # and in tension
        stress.append(np.sum(k * (strain - slip)))
    assert np.array(stress) == pytest.approx(path.stress, rel=2e-3, abs=2e-3 * 400e6)


def test_repeated_history_does_not_depend_on_its_start() -> None:
    m = jo.fatigue.strain_life("man-ten")
    S = 1e6 * np.array([0, 400, -100, 250, -350, 100, -200, 480, -300, 0.0])
    want = jo.fatigue.local_cycles(S, m, residue="repeat").damage
    for shift in range(1, 9):
        turned = np.concatenate([S[shift:], S[1 : shift + 1]])
        found = jo.fatigue.local_cycles(turned, m, residue="repeat").damage
        assert found == pytest.approx(want, rel=1e-12)


def test_counts_of_astm() -> None:
    # ASTM E1049-85, figure 6
    S = np.array([-2, 1, -3, 5, -1, 3, -4, 4, -2.0])
    i, j, count = loops(S, "half")
    found: dict[float, float] = {}
    for a, b, n in zip(i, j, count, strict=True):
        found[abs(S[a] - S[b])] = found.get(abs(S[a] - S[b]), 0.0) + n
    assert found == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_turning_points() -> None:
    plateaus = np.array([1, 1, 2, 2, 3, 3, 2, 2, 4, 4])
    assert turning_points(plateaus)[1].tolist() == [0, 4, 6, 8]
    assert turning_points(np.array([5, 5, 5]))[1].tolist() == [0]
    assert turning_points(np.array([5]))[1].tolist() == [0]


def test_keyhole_specimen_of_the_sae() -> None:
    # SAE keyhole programme (AE-6, 1977), specimen CR1 of RQC-100: K_t = 3, nominal +-149 MPa. The
    # benchmark page of efatigue.com gives 211,000 cycles by strain life, 605,000 by test.
    m = jo.fatigue.strain_life("rqc-100-sae")
    S = 3.0 * 149e6 * np.array([1.0, -1.0, 1.0])
    life = jo.fatigue.local_cycles(S, m, residue="repeat").life
    assert 0.9 * 211e3 < life < 1.1 * 211e3


def test_nothing_is_damaged_by_nothing() -> None:
    m = jo.fatigue.strain_life("sae-1045")
    loops = jo.fatigue.local_cycles([3e6, 3e6, 3e6], m, residue="half")
    assert loops.damage == 0.0 and loops.life == np.inf
    assert "life inf" in str(loops)


def test_mistakes_are_told_at_once() -> None:
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.StrainLife(210e9, -1.0, 0.1, 0.3, -0.5)
    assert len(told.value.problems) == 2
    with pytest.raises(jo.InputError, match="swapped"):
        jo.fatigue.StrainLife(210e9, 1e9, -0.6, 0.3, -0.09)
    with pytest.warns(jo.JoustoWarning, match="MPa"):
        jo.fatigue.StrainLife(210e9, 948.0, -0.09, 0.3, -0.5)
    with pytest.raises(jo.InputError, match="did you mean 'sae-1045'"):
        jo.fatigue.strain_life("sae 1046")
    m = jo.fatigue.strain_life("sae-1045")
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.local_cycles([], m, residue="halves", form="mansion")  # type: ignore[arg-type]
    assert "did you mean 'half'" in str(told.value) and "mansion" in str(told.value)
    with pytest.raises(jo.InputError, match="empty"):
        jo.fatigue.local_cycles([], m, residue="half")
    with pytest.raises(jo.InputError, match="finite"):
        jo.fatigue.local_cycles([0.0, np.nan], m, residue="half")
    with pytest.raises(TypeError, match="residue"):
        jo.fatigue.local_cycles([0.0, 1e6], m)  # type: ignore[call-arg]
    with pytest.warns(jo.JoustoWarning, match="percent"):
        m.cycles(2.0)
    with pytest.raises(jo.InputError, match="check the units"):
        jo.fatigue.StrainLife.uniform(500e6, 206e6)


def test_places_of_a_field() -> None:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 4, jo.Material(E=202e9, nu=0.3, rho=7850.0))
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=2))
    assert reduced.stress is not None
    x = np.array([0.0, 1.0, -0.5, 0.8, -1.0, 0.0])
    top = np.abs(reduced.stress.modes[:, 0, 0]).max()
    p = np.zeros((6, reduced.n))
    p[:, 0] = 600e6 / top * x  # 600 MPa at the worst place
    field = jo.recovery.field_from(reduced.stress, p, np.arange(6.0))
    m = jo.fatigue.strain_life("sae-1045")
    found = jo.fatigue.strain_damage(field, m, criterion="s11", residue="repeat")
    assert found.damage.max() == jo.fatigue.local_cycles(600e6 * x, m, residue="repeat").damage
    label = found.labels[int(np.argmax(found.damage))]
    one = jo.fatigue.strain_damage(field, m, residue="repeat", sites=[label])
    assert one.labels == (label,) and one.life[0] == pytest.approx(found.life.min(), rel=1e-6)
    assert label in str(one)
    with pytest.raises(jo.InputError, match="no sign"):
        jo.fatigue.strain_damage(field, m, criterion="von-mises", residue="half")


@given(
    st.floats(5e7, 3e8),
    st.floats(-1.0, 0.9),
    st.integers(1, 4),
    st.sampled_from(["half", "repeat"]),
)
def test_peaks_repeated_one_ulp_lower(a: float, r: float, n: int, residue: str) -> None:
    # rounding of equal ranges must not lose the first loading curve; damage as of exact repeats
    m = jo.fatigue.strain_life("sae-1045")
    b, lower = r * a, float(np.nextafter(a, 0.0))
    near = jo.fatigue.local_cycles([0.0, a, *[b, lower] * n], m, residue=residue)
    same = jo.fatigue.local_cycles([0.0, a, *[b, a] * n], m, residue=residue)
    assert near.damage == pytest.approx(same.damage, rel=1e-3, abs=1e-30)


def test_a_repeated_peak_that_lost_its_branch() -> None:
    S = [0, 136694895.0077239, -26809683.32321541, 136694895.00772387]
    loops = jo.fatigue.local_cycles(S, jo.fatigue.strain_life("sae-1045"), residue="half")
    assert np.all(np.isfinite(loops.cycles)) and len(loops.count)


def test_a_history_in_mpa_is_told() -> None:
    with pytest.warns(jo.JoustoWarning, match="in MPa"):
        jo.fatigue.local_cycles(
            [0.0, 200.0, -200.0], jo.fatigue.strain_life("sae-1045"), residue="half"
        )
