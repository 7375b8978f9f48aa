"""Bands of stress: exact for components, right for criteria, whole surfaces in blocks; damage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.twin.bands import bands
from jousto.measurement.twin.bands.bands import stress_band, stress_blocks
from jousto.measurement.twin.bands.life import damage_band
from jousto.measurement.twin.estimates import Posterior
from jousto.measurement.twin.smoother import smooth
from jousto.recovery.fields.criteria import evaluate
from jousto.reduction.fields.stress import StressModes
from measurement.twin.test_observer import shaken, twin


def modes_of(S: np.ndarray) -> StressModes:
    ns = len(S)
    return StressModes(
        tuple(f"n{i}" for i in range(ns)),
        np.zeros((ns, 3)),
        np.tile(np.eye(3), (ns, 1, 1)),
        S,
        np.tile([2.1e11, 0.3], (ns, 1)),
    )


@pytest.fixture
def posterior(rng: np.random.Generator) -> Posterior:
    root = rng.normal(size=(2, 3, 3))
    P = 1e-2 * root @ root.transpose(0, 2, 1)
    return Posterior(np.arange(6.0), rng.normal(size=(6, 3)), P, np.array([0, 1, 0, 1, 1, 0]))


def test_components_are_exact(posterior: Posterior, rng: np.random.Generator) -> None:
    S = 1e8 * rng.normal(size=(4, 6, 3))
    for c, name in enumerate(("s11", "s22", "s33", "s12", "s23", "s13")):
        band = stress_band(posterior, modes_of(S), name, sites=("n1", "n3"))
        for t in range(6):
            P = posterior.covariance[t]
            for k, site in enumerate((1, 3)):
                sd = np.sqrt(S[site, c] @ P @ S[site, c])
                assert band.value[t, k] == pytest.approx(S[site, c] @ posterior.p[t])
                assert band.high[t, k] - band.value[t, k] == pytest.approx(1.959964 * sd, rel=1e-6)
    normal = stress_band(posterior, modes_of(S), jo.recovery.Plane((1, 0, 0)))
    np.testing.assert_allclose(normal.low, stress_band(posterior, modes_of(S), "s11").low)


@pytest.mark.parametrize(
    "criterion", ["von-mises", "principal-1", "principal-3", "max-shear", "signed-principal"]
)
@pytest.mark.parametrize("size", [1e-4, 1e-2])
def test_criteria_hold_what_is_drawn(criterion: str, size: float, rng: np.random.Generator) -> None:
    """The truth drawn from the posterior lies within 95 % of the time, small spread or large."""
    S = 1e8 * rng.normal(size=(30, 6, 3))
    root = rng.normal(size=(3, 3))
    P = size * (root @ root.T + np.eye(3))
    p = rng.normal(size=(1, 3))
    found = stress_band(
        Posterior(np.zeros(1), p, P[None], np.zeros(1, dtype=np.intp)), modes_of(S), criterion
    )
    drawn = p + rng.multivariate_normal(np.zeros(3), P, 4000)
    truth = evaluate(np.einsum("scj,tj->tsc", S, drawn), criterion)
    inside = ((found.low <= truth) & (truth <= found.high)).mean(axis=0)
    assert inside.mean() == pytest.approx(0.95, abs=0.012)
    assert inside.min() > 0.84  # next to a change of sign


def test_von_mises_near_zero_is_sampled(rng: np.random.Generator) -> None:
    """At zero stress the gradient does not exist; a linearised band would be wrong."""
    S = np.zeros((1, 6, 1))
    S[0, 0, 0] = 1e8
    still = Posterior(np.zeros(1), np.zeros((1, 1)), np.ones((1, 1, 1)), np.zeros(1, dtype=np.intp))
    found = stress_band(still, modes_of(S), "von-mises")
    # |x| of a standard normal x: quantiles 2.5 % and 97.5 % are 0.0313 and 2.2414. Between ranks
    # of 128 draws, evenly spread: a rank is 1/128 of probability, at densities 0.797 and 0.0647
    rank = 1e8 / bands.DRAWS
    assert found.low[0, 0] == pytest.approx(0.0313e8, abs=rank / 0.797)
    assert found.high[0, 0] == pytest.approx(2.2414e8, abs=rank / 0.0647)


def test_blocks_are_the_whole(
    posterior: Posterior, rng: np.random.Generator, monkeypatch: pytest.MonkeyPatch
) -> None:
    modes = modes_of(1e8 * rng.normal(size=(23, 6, 3)))
    whole = stress_band(posterior, modes, "von-mises")
    monkeypatch.setattr(bands, "BLOCK_BYTES", 8 * 36 * 2 * 5)
    again, blocks = np.full((6, 23), np.nan), 0
    for instants, places, (value, low, high) in stress_blocks(posterior, modes, "von-mises"):
        again[instants, places] = high
        blocks += 1
        assert (low <= value).all()
    assert blocks > 5
    np.testing.assert_allclose(again, whole.high, rtol=1e-12)


def test_discrepancy_is_part_of_the_band(posterior: Posterior) -> None:
    class Missing(Posterior):
        @property
        def missed(self) -> float:
            return 1e-5

    S = np.zeros((1, 6, 3))
    blind = Missing(posterior.time, posterior.p, posterior.covariances, posterior.which)
    found = stress_band(blind, modes_of(S), "s11")
    np.testing.assert_allclose(found.high, 1.959964 * 2.1e11 * 1e-5, rtol=1e-6)
    # shear: G times the engineering strain
    shear = stress_band(blind, modes_of(S), "s12")
    np.testing.assert_allclose(shear.high, 1.959964 * 2.1e11 / 2.6 * 1e-5, rtol=1e-6)


def test_damage_lies_within_its_band(tmp_path: Path) -> None:
    record = shaken(11, nt=900)
    observer = twin(loads=[jo.twin.UnknownLoad("end", "fz", rate=28.0, size=2.0, smooth=True)])
    observed = observer.run(record.time, record.e)
    sn = jo.SN(S_D=20e6, N_D=1e6, k=5, rule="elementary")
    sites = ("e1.a.bottom", "e3.a.bottom")
    found = damage_band(
        observed, observer.reduced, sn, residue="half", sites=sites, criterion="s11", draws=30
    )
    stress = record.part.stress
    assert stress is not None
    truth = record.p @ stress.modes[[stress.labels.index(x) for x in sites], 0].T
    meter = jo.model.DamageMeter(sn, residue="half", n=2)
    meter.push(truth)
    assert ((found.low <= meter.damage()) & (meter.damage() <= found.high)).all()
    # half a per cent of stress is 2.5 % of damage with k = 5
    assert (found.high / found.low < 1.2).all()
    shortest, longest = found.life_band
    assert (shortest <= found.life).all() and (found.life <= longest).all()
    np.testing.assert_allclose(found.life * found.damage, 1.8)
    assert "95 % band" in str(found)
    lines = found.to_csv(tmp_path / "life.csv").read_text().splitlines()
    assert len(lines) == 3 and lines[1].split(",")[0] == "e1.a.bottom"
    assert float(lines[1].split(",")[1]) == pytest.approx(found.damage[0], rel=1e-5)
    with pytest.raises(jo.InputError, match="5 draws, must be 20 or more"):
        damage_band(smooth(observed), observer.reduced, sn, residue="half", draws=5)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"criterion": "mises"}, "'mises' is not a criterion of stress"),
        ({"sites": ("n9",)}, "no stress site 'n9'"),
        ({"sites": ()}, "sites is empty"),
        ({"level": 95.0}, "level is 95.0, must be between 0 and 1"),
    ],
)
def test_refusals(posterior: Posterior, options: dict[str, object], message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        stress_band(posterior, modes_of(np.ones((2, 6, 3))), **options)  # type: ignore[arg-type]


def test_other_modes_are_refused(posterior: Posterior) -> None:
    with pytest.raises(jo.InputError, match="stress of 4 modes, the estimate has 3"):
        stress_band(posterior, modes_of(np.ones((2, 6, 4))))


def test_table_and_picture(posterior: Posterior, tmp_path: Path, rng: np.random.Generator) -> None:
    band = stress_band(posterior, modes_of(1e8 * rng.normal(size=(3, 6, 3))), "s11")
    lines = band.to_csv(tmp_path / "band.csv").read_text().splitlines()
    assert lines[0].split(",")[:3] == ["time s", "n0 s11 MPa", "n0 low MPa"]
    assert float(lines[2].split(",")[1]) == pytest.approx(1e-6 * band.value[1, 0], rel=1e-6)
    picture = jo.plot(
        band, sites=("n2", "n0"), truth=band.value[:, [2, 0]], path=tmp_path / "band.png"
    )
    assert (tmp_path / "band.png").stat().st_size > 5000
    assert [ax.get_title() for ax in picture.axes] == ["n2, s11", "n0, s11"]
    with pytest.raises(jo.InputError, match="no place 'n7'"):
        jo.plot(band, sites="n7")
    with pytest.raises(jo.InputError, match=r"truth has shape \(6, 1\), must be \(6, 3\)"):
        jo.plot(band, truth=band.value[:, :1])
