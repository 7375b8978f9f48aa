"""Modes weighed by strain energy: the weight of the largest evidence, formulas, loads."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

import jousto as jo

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
NOISE = 1e-6


def system(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Strain rows (6, 9) and stiffness (9,) over four decades."""
    return rng.normal(size=(6, 9)), np.logspace(0, 4, 9)


def record(
    B: np.ndarray, W: np.ndarray, a: float, count: int, rng: np.random.Generator
) -> np.ndarray:
    p = rng.normal(size=(count, len(W))) / np.sqrt(a * W)
    return np.asarray(p @ B.T + NOISE * rng.normal(size=(count, len(B))))


def test_the_weight_of_a_record_is_found(rng: np.random.Generator) -> None:
    """Coordinates drawn with the covariance (a W)^-1; 6 x 4000 samples tell a within 1.5 %."""
    B, W = system(rng)
    for a in (1e6, 1e9):
        found = jo.twin.weigh_modes(B, record(B, W, a, 4000, rng), W, noise=NOISE, by="energy")
        assert found.a == pytest.approx(a, rel=0.06)


def test_the_evidence_is_the_density_of_the_strains(rng: np.random.Generator) -> None:
    """``e ~ N(0, R + S (a W)^-1 S^T)`` by scipy; the weight is its maximum."""
    B, W = system(rng)
    C = rng.normal(size=(6, 6))
    R = NOISE**2 * (np.eye(6) + 0.1 * C @ C.T)
    K = np.diag(W) + 0.3 * np.sqrt(np.outer(W, W))
    e = record(B, W, 1e7, 20, rng)
    found = jo.twin.weigh_modes(B, e, K, noise=R, by="energy")

    def density(a: float) -> float:
        cov = R + B @ np.linalg.inv(a * K) @ B.T
        return float(scipy.stats.multivariate_normal(np.zeros(6), cov).logpdf(e).sum())

    still = float(scipy.stats.multivariate_normal(np.zeros(6), R).logpdf(e).sum())
    assert found.evidence == pytest.approx(density(found.a) - still, rel=1e-9)
    for factor in (0.5, 0.99, 1.01, 2.0):
        assert density(factor * found.a) < density(found.a)


def test_estimate_and_counts_are_those_of_the_formulas(rng: np.random.Generator) -> None:
    B, W = system(rng)
    e = record(B, W, 1e7, 30, rng)
    found = jo.twin.weigh_modes(B, e, W, noise=NOISE, by="energy")
    R1, aW = np.eye(6) / NOISE**2, found.a * np.diag(W)
    inverse = np.linalg.inv(B.T @ R1 @ B + aW)
    p = found.reconstruction.estimate(e).p
    np.testing.assert_allclose(p, e @ R1 @ B @ inverse.T, rtol=1e-6, atol=1e-9 * np.abs(p).max())
    share = inverse @ B.T @ R1 @ B
    assert found.effective == pytest.approx(np.trace(share), rel=1e-9)
    np.testing.assert_allclose(found.seen, np.diag(share), atol=1e-9)
    assert f"{found.effective:.2f} of 9 modes" in str(found)


def test_modes_without_strain_at_the_gauges_are_not_seen(rng: np.random.Generator) -> None:
    B, W = system(rng)
    B[:, [2, 7]] = 0.0
    found = jo.twin.weigh_modes(B, record(B, W, 1e6, 50, rng), W, noise=NOISE)
    assert {3, 8} <= set(found.unseen)
    assert "modes not seen: " + ", ".join(map(str, found.unseen)) in str(found)
    assert np.abs(found.reconstruction.estimate(np.ones((1, 6)) * 1e-5).p[0, [2, 7]]).max() == 0.0


def test_units_of_the_modes_do_not_matter(rng: np.random.Generator) -> None:
    """Modes of other lengths have other rows and stiffness, and the same strains."""
    B, W = system(rng)
    e = record(B, W, 1e7, 30, rng)
    scale = np.logspace(-3, 3, 9)
    a, b = (
        jo.twin.weigh_modes(rows, e, K, noise=NOISE, by="energy")
        for rows, K in ((B, W), (B * scale, W * scale**2))
    )
    assert b.a == pytest.approx(a.a, rel=1e-6)
    np.testing.assert_allclose(
        b.reconstruction.estimate(e).p * scale,
        a.reconstruction.estimate(e).p,
        rtol=1e-4,
        atol=1e-12,
    )


def test_gaps_are_left_out(rng: np.random.Generator) -> None:
    B, W = system(rng)
    e = record(B, W, 1e7, 30, rng)
    with_gaps = np.insert(e, 10, np.nan, axis=0)
    a, b = (jo.twin.weigh_modes(B, x, W, noise=NOISE).a for x in (e, with_gaps))
    assert a == pytest.approx(b, rel=1e-9)


def test_the_kind_of_the_larger_evidence_is_taken(rng: np.random.Generator) -> None:
    B, W = system(rng)
    for K, kind in ((W, "energy"), (W**2, "loads")):
        e = record(B, K, 1e7, 400, rng)
        both = [jo.twin.weigh_modes(B, e, W, noise=NOISE, by=by) for by in ("energy", "loads")]
        found = jo.twin.weigh_modes(B, e, W, noise=NOISE)
        assert found.by == kind
        assert found.evidence == max(x.evidence for x in both)
        assert found.a == pytest.approx(1e7, rel=0.2)


def cantilever(modes: int) -> tuple[jo.ReducedPart, np.ndarray]:
    """The modes of a cantilever in its plane and their strains at eight gauges."""
    rod = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 12, STEEL)
    whole = jo.reduce(rod, jo.CraigBampton(["start", "end"], modes=modes))
    body = jo.reduction.clamp(whole, "start")
    body = body.keep(body.in_plane("xz"))
    assert body.stress is not None
    sites = [f"e{k}.a.{side}" for k in (2, 5, 8, 11) for side in ("top", "bottom")]
    places = [body.stress.labels.index(site) for site in sites]
    return body, body.stress.modes[places, 0] / STEEL.E


@pytest.mark.parametrize("force", [3.0, -100.0])
@pytest.mark.parametrize("modes", [6, 14])
def test_a_tip_load_is_found_and_no_mode_is_left_out(
    force: float, modes: int, rng: np.random.Generator
) -> None:
    """Surface strain ``6 F (L - x) / (E b h^2)`` of a beam; 7 and 11 modes, 4 places of gauges."""
    body, B = cantilever(modes)
    x = np.array([1, 4, 7, 10]) / 12
    strain = -6 * force * (1 - x) / (STEEL.E * 0.02 * 0.01**2)
    exact = np.column_stack([strain, -strain]).ravel()
    e = exact + NOISE * rng.normal(size=(400, 8))
    found = jo.twin.weigh_modes(B, e, body, noise=NOISE)
    load, band = found.place_loads(e, [jo.twin.UnknownLoad("end", ("fz",))], body)
    # four standard deviations of the mean of 400 instants
    chance = 4 * float(load.std()) / 400**0.5
    assert chance < 0.1
    assert float(load.mean()) == pytest.approx(force, rel=1e-3, abs=chance)
    assert band.shape == (1,) and band[0] > 0.0
    # stress everywhere, also between the gauges
    p = found.reconstruction.estimate(e).p.mean(axis=0)
    assert body.stress is not None
    tip = body.modes[body.node("end")][2]
    static = body.stress.modes[:, 0] @ (force * tip / body.stiffness)
    error = np.abs(body.stress.modes[:, 0] @ p - static).max()
    assert error < 0.06 * np.abs(static).max()
    if force == -100.0:
        assert found.by == "loads"


def tip_load(count: int, other: float, rng: np.random.Generator) -> tuple[float, float, float]:
    """Errors (rms) of a tip load and of least squares with the noise alone, N, and the band.

    Other motions are drawn with the covariance ``(other k_1)^2 K^-2``, k_1 of the first mode.
    """
    rod = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, STEEL)
    whole = jo.reduce(rod, jo.CraigBampton(("start", "end"), modes=3))
    body = jo.reduction.clamp(whole, "start")
    body = body.keep(body.in_plane("xz"))
    places = zip((0.05, 0.2, 0.35, 0.5, 0.65, 0.8), 3 * (0.005, -0.005), strict=True)
    gauges = [jo.gauges.Gauge(f"g{k}", body, (x, 0.0, z)) for k, (x, z) in enumerate(places)]
    B = jo.gauges.gauge_rows(gauges, body)[:count]
    force = 20.0 * np.sin(np.linspace(0.0, 6.0, 200))
    unit = B @ (body.modes[body.node("end"), 2] / body.stiffness)
    p = other * body.stiffness[0] * rng.normal(size=(200, len(body.stiffness))) / body.stiffness
    e = np.outer(force, unit) + p @ B.T + NOISE * rng.normal(size=(200, count))
    found = jo.twin.weigh_modes(B, e, body, noise=NOISE)
    loads, band = found.place_loads(e, [jo.twin.UnknownLoad("end", ("fz",))], body)
    plain = e @ unit / (unit @ unit) - force
    return float((loads[:, 0] - force).std()), float(plain.std()), float(band[0])


@pytest.mark.parametrize("count", [1, 3, 6])
def test_a_load_that_explains_all_does_not_compete_with_itself(
    count: int, rng: np.random.Generator
) -> None:
    """Least squares is the best of 200 instants; a deviation of theirs has 5 % of chance."""
    error, plain, band = tip_load(count, 0.0, rng)
    assert error < 1.05 * plain
    assert error / band == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("other", [5e-4, 2e-3])
@pytest.mark.parametrize("count", [3, 6])
def test_the_band_grows_with_other_motions(
    count: int, other: float, rng: np.random.Generator
) -> None:
    error, _, band = tip_load(count, other, rng)
    assert 0.5 < error / band < 2.0
    assert band > 2.0 * tip_load(count, 0.0, rng)[2]


def test_the_weight_of_other_motions_is_the_restricted_maximum(rng: np.random.Generator) -> None:
    """``log|C| + log|H^T C^-1 H| + e^T P e`` (Patterson, Thompson 1971) is least there."""
    B, W = system(rng)
    L = rng.normal(size=(9, 2)) * np.sqrt(W)[:, None]
    H = B @ (L / W[:, None])
    e = record(B, W, 1e8, 30, rng) + 1e-5 * rng.normal(size=(30, 2)) @ H.T
    loads, band = jo.twin.weigh_modes(B, e, W, noise=NOISE, by="energy").place_loads(e, L)

    def fitted(log_b: float, G: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        C = NOISE**2 * np.eye(6) + B @ np.diag(np.exp(-log_b) / G) @ B.T
        Ci = np.linalg.inv(C)
        info = H.T @ Ci @ H
        F = np.linalg.solve(info, H.T @ Ci @ e.T).T
        P = Ci - Ci @ H @ np.linalg.solve(info, H.T @ Ci)
        least = 30 * (np.linalg.slogdet(C)[1] + np.linalg.slogdet(info)[1])
        return (
            float(least + np.einsum("ti,ij,tj", e, P, e)),
            F,
            np.sqrt(np.diag(np.linalg.inv(info))),
        )

    tried = [(x, G) for G in (W, W**2) for x in np.arange(5.0, 35.0, 0.02)]
    _, F, wanted = min((fitted(*one) for one in tried), key=lambda found: found[0])
    np.testing.assert_allclose(band, wanted, rtol=0.02)
    np.testing.assert_allclose(loads, F, atol=0.02 * wanted.max())


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ("end", "loads is 'end', must be at least one UnknownLoad"),
        ([], "must be at least one UnknownLoad"),
        (None, "loads is None, must be at least one UnknownLoad"),
        ([jo.twin.UnknownLoad("end", "fz"), "end"], "must be at least one UnknownLoad"),
        (jo.twin.UnknownLoad("start", "fz"), "load 1 strains none of the gauges"),
        (jo.twin.UnknownLoad("end", ("fz", "my")), "1 gauge cannot distinguish 2 loads"),
    ],
)
def test_wrong_loads_are_named(loads: object, message: str, rng: np.random.Generator) -> None:
    body, B = cantilever(6)
    e = 1e-4 + NOISE * rng.normal(size=(5, 1))
    found = jo.twin.weigh_modes(B[:1], e, body, noise=NOISE)
    with pytest.raises(jo.InputError, match=message):
        found.place_loads(e, loads, body)
    with pytest.raises(jo.InputError, match="no instants"):
        found.place_loads(e[:0], jo.twin.UnknownLoad("end", "fz"), body)


def test_the_band_of_loads_holds(rng: np.random.Generator) -> None:
    """Loads beside motions of the size of the prior: deviations have the size of the band."""
    B, W = system(rng)
    L = rng.normal(size=(9, 2)) * np.sqrt(W)[:, None]
    e = record(B, W, 1e9, 4000, rng)
    found = jo.twin.weigh_modes(B, e, W, noise=NOISE, by="energy")
    F = np.array([1e-3, -2e-3])
    loads, band = found.place_loads(e + B @ (L / W[:, None]) @ F, L)
    np.testing.assert_allclose((loads - F).std(axis=0) / band, 1.0, atol=0.06)
    np.testing.assert_allclose(loads.mean(axis=0), F, atol=4 * band.max() / 4000**0.5)
    with pytest.raises(jo.InputError, match="cannot distinguish 2 loads"):
        found.place_loads(e, L[:, [0, 0]])
    with pytest.raises(jo.InputError, match="loads has shape"):
        found.place_loads(e, L[:-1])
    with pytest.raises(jo.InputError, match="have gaps"):
        found.place_loads(e * np.nan, L)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda B, e, W: (B, e, W[:-1]), "stiffness has shape"),
        (lambda B, e, W: (B, e[:, :-1], W), "5"),
        (lambda B, e, W: (B, e * np.nan, W), "every instant"),
        (lambda B, e, W: (B, e, np.append(W[:-1], 0.0)), "without strain energy"),
        (lambda B, e, W: (B, e, np.diag(W) + np.eye(9, k=1)), "not symmetric"),
        (lambda B, e, W: (B * 0.0, e, W), "no gauge is strained"),
        (lambda B, e, W: (B, e * 0.0, W), "0 times the noise"),
        (lambda B, e, W: (B[:0], e[:, :0], W), "0 rows and 9 columns"),
        (lambda B, e, W: (B, e[:0], W), "no instants"),
        (lambda B, e, W: (B, e, None), "part is None, must be a ReducedPart"),
    ],
)
def test_wrong_records_are_named(change: object, message: str, rng: np.random.Generator) -> None:
    B, W = system(rng)
    given = change(B, record(B, W, 1e7, 30, rng), W)  # type: ignore[operator]
    with pytest.raises(jo.InputError, match=message):
        jo.twin.weigh_modes(*given, noise=NOISE)
