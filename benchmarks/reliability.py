"""FORM, SORM and importance sampling beside OpenTURNS and Pystra on ten limit states.

python benchmarks/reliability.py    some seconds

The limit states are those of `tests/design/limit_states.py`. Calls of the limit state are counted
where it is called, with those for differences. Both other programs are asked with their own
tolerances (1e-5 and 1e-3 of their residuals) and with 1e-6, that of jousto; OpenTURNS with each of
its three algorithms. `distance` is that of a design point from jousto's, in standard normal space.
"""

from __future__ import annotations

import inspect
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import openturns as ot
import pystra as ra

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

import jousto as jo
from design.limit_states import TEN, slopes
from jousto.design.reliability.limit import named

ot.Log.Show(ot.Log.NONE)
STRICT = 1e-6
ERRORS = ("AbsoluteError", "RelativeError", "ResidualError", "ConstraintError")


def openturns_event(function: Callable[..., Any], variables: list[Any]) -> tuple[Any, list[int]]:
    """Return the event of failure and a counter of its calls."""
    names, calls = [one.name for one in variables], [0]

    def g(x: Any) -> list[float]:
        calls[0] += 1
        return [float(function(named(names, x)))]

    laws = []
    for one in variables:
        if one.kind == "norm":
            laws.append(ot.Normal(one.mean, one.deviation))
        else:
            laws.append(ot.LogNormalMuSigma(one.mean, one.deviation, 0.0).getDistribution())
    vector = ot.RandomVector(ot.JointDistribution(laws))
    state = ot.PythonFunction(len(names), 1, g)
    composite = ot.CompositeRandomVector(state, vector)
    return ot.ThresholdEvent(composite, ot.LessOrEqual(), 0.0), calls


def openturns(
    function: Callable[..., Any], variables: list[Any], kind: str, tolerance: float | None
) -> tuple[float, int, Any]:
    event, calls = openturns_event(function, variables)
    solver = getattr(ot, kind)()
    solver.setStartingPoint([one.mean for one in variables])
    solver.setMaximumCallsNumber(10_000)
    if tolerance is not None:
        for error in ERRORS:
            getattr(solver, f"setMaximum{error}")(tolerance)
    analysis = ot.FORM(solver, event)
    analysis.run()
    found = analysis.getResult()
    u = np.array(found.getStandardSpaceDesignPoint())
    return found.getHasoferReliabilityIndex(), calls[0], u


def pystra(
    function: Callable[..., Any], variables: list[Any], tolerance: float | None
) -> tuple[float, int, Any]:
    names, calls = [one.name for one in variables], [0]

    def g(**x: Any) -> Any:
        values = np.array([np.atleast_1d(x[name]) for name in names], dtype=float)
        calls[0] += values.shape[1]
        return function(named(names, values))

    kind = inspect.Parameter.KEYWORD_ONLY
    g.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [inspect.Parameter(name, kind) for name in names]
    )
    model = ra.StochasticModel()
    for one in variables:
        law = ra.Normal if one.kind == "norm" else ra.Lognormal
        model.addVariable(law(one.name, one.mean, one.deviation))
    options = ra.AnalysisOptions()
    options.setPrintOutput(False)
    if tolerance is not None:
        options.setE1(tolerance)
        options.setE2(tolerance)
        options.setImax(500)
    analysis = ra.Form(
        analysis_options=options, limit_state=ra.LimitState(g), stochastic_model=model
    )
    analysis.run()
    return (
        float(np.ravel(analysis.beta)[0]),
        calls[0],
        np.ravel(analysis.getDesignPoint(uspace=True)),
    )


def main() -> None:
    warnings.simplefilter("ignore")
    print(f"{'':13}{'program':22}{'beta':>12}{'calls':>7}{'distance':>10}")
    wins = np.zeros(3, int)
    for name, (function, variables) in TEN.items():
        ours = jo.design.form(function, variables)
        rows = [("jousto sqp", ours.beta, ours.calls, ours.u)]
        exact = jo.design.form(
            jo.design.LimitState(function, gradient=slopes(function, variables)), variables
        )
        rows.append(("jousto, gradient given", exact.beta, exact.calls, exact.u))
        slow = jo.design.form(function, variables, method="hlrf")
        rows.append(("jousto hlrf", slow.beta, slow.calls, slow.u))
        for kind in ("AbdoRackwitz", "SQP", "Cobyla"):
            for tolerance in (None, STRICT):
                label = f"openturns {kind[:6]}{' 1e-6' if tolerance else ''}"
                rows.append((label, *openturns(function, variables, kind, tolerance)))
        for tolerance in (None, STRICT):
            label = f"pystra{' 1e-6' if tolerance else ''}"
            rows.append((label, *pystra(function, variables, tolerance)))
        for label, beta, calls, u in rows:
            distance = np.linalg.norm(u - ours.u)
            print(f"{name:13}{label:22}{beta:12.8f}{calls:7d}{distance:10.1e}")
            name = ""
        best = min(calls for _, _, calls, _ in rows[3:])
        wins += np.array(
            [ours.calls <= best, exact.calls < best, exact.calls + exact.gradients < best]
        )
    print(
        f"jousto takes no more calls than the best of the others in {wins[0]} of {len(TEN)}; with "
        f"gradients fewer in {wins[1]}, fewer with the gradients counted as calls in {wins[2]}"
    )
    probabilities()


def probabilities() -> None:
    """Print probabilities of the second order and of 2000 points about the design point."""
    print(
        f"\n{'':13}{'FORM':>11}{'SORM':>11}{'OpenTURNS':>11}{'sampled':>11}{'+-':>8}{'OpenTURNS':>11}"
    )
    for name, (function, variables) in TEN.items():
        second = jo.design.sorm(function, variables)
        sampled = jo.design.importance_sampling(second.form, samples=2000)
        event, _ = openturns_event(function, variables)
        solver = ot.AbdoRackwitz()
        solver.setStartingPoint(list(second.form.x))
        solver.setMaximumCallsNumber(10_000)
        try:
            theirs = ot.SORM(solver, event)
            theirs.run()
            tvedt = theirs.getResult().getEventProbabilityTvedt()
        except RuntimeError:
            tvedt = float("nan")
        analysis = ot.FORM(solver, event)
        analysis.run()
        around = ot.PostAnalyticalImportanceSampling(analysis.getResult())
        around.setMaximumOuterSampling(2000)
        around.setBlockSize(1)
        around.setMaximumCoefficientOfVariation(0.0)
        around.run()
        other = around.getResult().getProbabilityEstimate()
        print(
            f"{name:13}{second.form.probability:11.3e}{second.tvedt:11.3e}{tvedt:11.3e}"
            f"{sampled.probability:11.3e}{sampled.variation:8.1%}{other:11.3e}"
        )


if __name__ == "__main__":
    main()
