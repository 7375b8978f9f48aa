"""The error budget of a stress: each term against a run in which it alone is refined."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.parts.solids.stress import SolidStress
from verification import statics as st
from verification.test_mesh_error import PROBLEMS


def link(folder: Path, name: str, *, modes: int, step: float, every: float) -> jo.Solution:
    """A link that is hit at its end, clamped."""
    part = jo.Part.beam(0.8, jo.Rectangle(0.02, 0.05), 12, jo.material("S355"))
    body = jo.FlexibleBody("link", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes)))
    blow = jo.SCurve([0.0, 0.004, 0.008], [0.0, 1.0, 0.0])
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Fixed("root", jo.ground["origin"], body["start"]),
            jo.Force("blow", body["end"], (0.0, 300.0, 500.0), signal=blow),
        )
    )
    path = folder / f"{name}.h5"
    return jo.simulate(model, 0.042, solver=jo.ROS2(step), output_step=every, path=path)


def test_the_budget_holds_the_error(tmp_path: Path) -> None:
    """Coarse in modes, step and instants against a run that is fine in all of them."""
    coarse = link(tmp_path, "coarse", modes=1, step=2e-4, every=2e-4)
    half = link(tmp_path, "half", modes=1, step=1e-4, every=2e-4)
    many = link(tmp_path, "many", modes=12, step=2e-4, every=2e-4)
    truth = link(tmp_path, "truth", modes=12, step=5e-6, every=1e-5)
    found = jo.hot_spots(coarse, count=1)
    budget = jo.recovery.error_budget(found, step=half, modes=many)
    site = found[0].site
    exact = jo.stress_field(truth, "link", sites=site).values("von-mises").max()
    error = abs(exact - found[0].value)
    assert error > 1e-3 * exact  # there is one
    # ROS2 is of second order: half the step shows three quarters of its error
    assert error <= budget.known + budget.terms["step"]
    assert budget.known < 20.0 * error  # and it is no wild guess
    assert budget.unknown == ("mesh",)
    assert budget.value == found[0].value
    text = repr(budget)
    assert text.startswith(f"<ErrorBudget: 'link' {site}, von-mises") and "\n" not in text
    assert "not known: mesh" in text and "finer mesh" in str(budget)


def test_what_is_not_refined_is_not_known(tmp_path: Path) -> None:
    run = link(tmp_path, "run", modes=1, step=2e-4, every=2e-4)
    found = jo.hot_spots(run, count=2)
    budget = jo.recovery.error_budget(found, 2)
    assert budget.unknown == ("modes", "step", "mesh")
    none = replace(budget, terms=dict.fromkeys(budget.terms, float("nan")))
    assert str(none).splitlines()[0].endswith("MPa: not known: modes, step, mesh, instants")
    # nothing changed: no error but the order of sums
    same = jo.recovery.error_budget(found, step=run, modes=jo.stress_field(run, "link"), mesh=run)
    terms = [same.terms[name] for name in ("step", "modes", "mesh")]
    assert terms == pytest.approx([0.0, 0.0, 0.0], abs=1e-13 * found[1].value)
    with pytest.raises(InputError, match="rank is 3, must be from 1 to 2"):
        jo.recovery.error_budget(found, 3)


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10", "wedge15"])
@pytest.mark.parametrize("layers", [4, 8])
def test_error_of_a_place(kind: str, layers: int, problem: str) -> None:
    """By how much elements disagree is the error there: in the mean within a factor of two."""
    make, exact = PROBLEMS[problem]
    solved = make(kind, layers)
    x = solved.part.nodes
    V = np.diag([1.5, 1.5, 1.5, 3.0, 3.0, 3.0])
    V[:3, :3] -= 0.5
    away = solved.s - exact(x)
    true = np.sqrt(np.einsum("ni,ij,nj->n", away, V, away))
    found = jo.parts.place_errors(solved.part, solved.d.reshape(-1))[:, 0]
    assert isinstance(solved.part.stress, SolidStress) and len(found) == len(solved.part.stress)
    edge = st.near(np.hypot(x[:, 0], x[:, 1]), st.HOLE if problem == "hole" else st.BORE)
    peak = int(np.flatnonzero(edge)[np.argmax(np.abs(exact(x)[edge]).max(axis=1))])
    for some, low in ((slice(None), 0.5), (edge, 0.5), ([peak], 0.4)):
        ratio = np.sqrt(np.mean(found[some] ** 2) / np.mean(true[some] ** 2))
        assert low < ratio < 2.0
