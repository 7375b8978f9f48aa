"""Which modes are corrections: strain energy split into static shapes and vibrations."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.schema.summary import content_facts
from jousto.sections.section import Rectangle
from reduction.bodies import bent

BOTH = ("start", "end")


@pytest.mark.parametrize("modes", [0, 3, 8])
def test_shares_are_those_of_guyans_stiffness(modes: int) -> None:
    """u_B^T (K_BB - K_BI K_II^-1 K_IB) u_B over omega^2, from the whole stiffness matrix."""
    part = bent()
    r = reduce(part, CraigBampton(BOTH, modes=modes))
    K = part.K.toarray()
    B = np.concatenate([6 * part.node_sets[name][0] + np.arange(6) for name in BOTH])
    inside = np.setdiff1d(np.arange(len(K)), B)
    guyan = K[np.ix_(B, B)] - K[np.ix_(B, inside)] @ np.linalg.solve(
        K[np.ix_(inside, inside)], K[np.ix_(inside, B)]
    )
    assert r.rotations is not None
    u = np.concatenate([r.modes, r.rotations], axis=1).reshape(len(K), r.n)[B]
    expected = np.einsum("ij,ik,kj->j", u, guyan, u) / r.stiffness
    # the energies of a matrix of 1e10 N/m and soft shapes: eight digits are left
    np.testing.assert_allclose(r.static_shares, expected, atol=1e-6)
    # as many as two nodes deform against one another
    assert r.static_shares.sum() == pytest.approx(6.0, abs=1e-9)


def test_all_modes_of_static_condensation_are_static_and_none_of_one_interface() -> None:
    np.testing.assert_allclose(reduce(bent(), CraigBampton(BOTH, modes=0)).static_shares, 1.0)
    for method in (CraigBampton(("start",), modes=4), FreeFree(modes=5)):
        np.testing.assert_allclose(reduce(bent(), method).static_shares, 0.0, atol=1e-12)


def test_attachment_modes_span_the_static_shapes_too() -> None:
    r = reduce(bent(), FreeFree(modes=5, interfaces=BOTH))
    assert r.static_shares.sum() == pytest.approx(6.0, abs=1e-9)
    assert r.static_shares.max() <= 1.0 + 1e-12


def test_the_summary_labels_corrections() -> None:
    r = reduce(bent(), CraigBampton(BOTH, modes=3))
    rows = dict(content_facts(r))
    for j, share in enumerate(r.static_shares):
        kind = "correction" if share > 0.5 else "vibration"
        text = f"{r.frequencies[j]:.6g} Hz, {kind}, {100 * share:.0f} % static"
        assert rows[f"mode {j + 1}"] == text
    assert {text.split(", ")[1] for name, text in rows.items() if name.startswith("mode")} == {
        "correction",
        "vibration",
    }
    with_loads = dict(content_facts(reduce(bent(), FreeFree(modes=5, interfaces=BOTH))))
    assert "vibration" not in with_loads["mode 1"]  # its basis does not say which is which


def test_a_correction_may_be_near_a_natural_frequency() -> None:
    """The steel rod of the page of the command line; weak axis, strong axis, weak axis: free-free.

    Frequencies of the full part bound those of the reduced one from below, whatever the share.
    """
    steel = Material(E=210e9, nu=0.3, rho=7850.0)
    part = Part.beam(1.0, Rectangle(0.02, 0.01), 10, steel)
    r = reduce(part, CraigBampton(BOTH, modes=2))
    natural = reduce(part, FreeFree(modes=8)).frequencies
    assert (r.static_shares[:3] > 0.5).all()
    np.testing.assert_allclose(natural[:3], (53.15, 106.18, 146.44), rtol=1e-4)
    np.testing.assert_allclose(r.frequencies[:3], (53.34, 106.57, 217.67), rtol=1e-4)
    assert (r.frequencies >= natural[:8] * (1 - 1e-9)).all()
