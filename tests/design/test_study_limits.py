"""Limit states that are outcomes of a study, against closed forms of a pushed block."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import jousto as jo
from jousto.base.errors import InputError

M, SM, F, SF = 2.0, 0.2, 4.0, 0.4  # kg, N


def block(mass: float) -> jo.Mechanism:
    """Return a block that a force pushes: after 1 s it is F / 2 m away."""
    body = jo.RigidBody("block", mass, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", slide.displacement, jo.Input("force"))
    return jo.Mechanism(body, slide, push, jo.CoordinateSensor("way", slide.displacement))


def parameters(sd: float = SM) -> list[jo.Parameter]:
    return [
        jo.Parameter("mass", M, (1.0, 4.0), unit="kg", distribution=norm(M, sd)),
        jo.Parameter("force", F, unit="N", distribution=norm(F, SF)),
    ]


def of_block(outcomes: Any = "last(way)", sd: float = SM) -> jo.design.Study:
    return jo.study(block, parameters(sd), outcomes, t_end=1.0, solver=jo.RK4(0.1))


def beta(c: float) -> float:
    """Return the index of ``F / 2 m <= c``: 2 c m - F is linear in normal variables."""
    return (2 * c * M - F) / math.hypot(2 * c * SM, SF)


def test_form_in_one_line_meets_the_closed_form_and_simulates_each_point_once() -> None:
    study = of_block()
    limit = jo.design.limit_state(study, "last(way) <= 1.5 m")
    found = jo.design.form(limit)
    # differences of 1e-3 deviations leave as much of the direction, its square of the index
    assert found.beta == pytest.approx(beta(1.5), abs=1e-5)
    share = (2 * 1.5 * SM) ** 2 / ((2 * 1.5 * SM) ** 2 + SF**2)
    assert found.importance["mass"] == pytest.approx(share, abs=2e-3)
    runs = study.counts["runs"]
    assert runs <= found.calls
    again = jo.design.form(limit)
    assert again.calls == found.calls and study.counts["runs"] == runs


def test_limits_of_one_study_share_its_runs() -> None:
    study = of_block(["last(way)", "v = rms(way)"])
    first = jo.design.limit_state(study, "last(way) <= 1.5")
    second = jo.design.limit_state(study, "far = v <= 1.2")
    assert second.name == "far"
    jo.design.monte_carlo(first, samples=40, seed=3)
    assert study.counts["runs"] == 40
    jo.design.monte_carlo(second, samples=40, seed=3)
    assert study.counts["runs"] == 40


def test_every_method_takes_it_alone() -> None:
    pushed = [
        jo.Parameter("mass", M, unit="kg"),
        jo.Parameter("force", F, unit="N", distribution=norm(F, SF)),
    ]
    study = jo.study(block, pushed, "last(way)", t_end=1.0, solver=jo.RK4(0.1))
    limit = jo.design.limit_state(study, "last(way) <= 1.1 m")
    exact = float(norm.sf((2 * 1.1 * M - F) / SF))
    found = jo.design.form(limit)
    assert found.probability == pytest.approx(exact, rel=1e-6)
    assert jo.design.sorm(limit).tvedt == pytest.approx(exact, rel=1e-5)
    sampled = [
        jo.design.importance_sampling(found, samples=200, confidence=0.999),
        jo.design.monte_carlo(limit, samples=200, confidence=0.999),
        jo.design.subset_simulation(limit, samples=100, confidence=0.999),
    ]
    for one in sampled:
        assert one.low < exact < one.high
    at = jo.design.pma(limit, beta=2.0)
    assert at.value == pytest.approx(1.1 - (F + 2.0 * SF) / 2 / M, abs=1e-9)


def test_design_for_a_target_moves_means_beyond_their_scatter() -> None:
    limit = jo.design.limit_state(of_block(), "last(way) <= 1.5 m")
    # 3 m - F = 3 hypot(3 SM, SF): the least mean mass; lighter blocks are simulated on the way
    best = jo.design.rbdo(lambda d: d["mass"], [limit], bounds={"mass": (1.0, 4.0)}, beta=3.0)
    exact = (F + 3.0 * math.hypot(3 * SM, SF)) / 3.0
    assert best.design["mass"] == pytest.approx(exact, rel=1e-4)


def test_a_strength_that_only_the_bound_has_needs_no_runs_of_its_own() -> None:
    reach = jo.Parameter("reach", 1.5, unit="m", distribution=norm(1.5, 0.1))
    pushed = [jo.Parameter("force", F, unit="N", distribution=norm(F, SF))]
    study = jo.study(lambda: block(M), pushed, "last(way)", t_end=1.0, solver=jo.RK4(0.1))
    limit = jo.design.limit_state(study, "last(way) <= ${reach - 10 cm}", parameters=[reach])
    found = jo.design.form(limit)
    assert found.beta == pytest.approx((1.4 - F / 4) / math.hypot(0.1, SF / 4), rel=1e-6)
    # without memory a gradient costs a run for each of the two variables
    assert study.counts["runs"] < found.calls


def test_frequency_as_a_limit() -> None:
    def sprung(mass: float, k: float) -> jo.Mechanism:
        body = jo.RigidBody("block", mass, (1, 1, 1))
        slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
        return jo.Mechanism(body, slide, jo.Spring("k", slide.displacement, k))

    stiff = jo.Parameter("k", 800.0, unit="N/m", distribution=norm(800, 40))
    study = jo.study(sprung, [parameters()[0], stiff], "frequency(1)")
    found = jo.design.form(jo.design.limit_state(study, "frequency(1) >= 2.8 Hz"))
    w2 = (2 * np.pi * 2.8) ** 2  # k - w^2 m is linear
    assert found.beta == pytest.approx((800 - w2 * M) / math.hypot(w2 * SM, 40), abs=1e-5)
    assert study.counts["runs"] == 0


def test_a_given_gradient_is_used() -> None:
    def slopes(x: np.ndarray[Any, Any]) -> Any:
        mass, force = x
        return [[-force / 2 / mass**2, 1 / 2 / mass]]

    study = of_block()
    limit = jo.design.limit_state(study, "last(way) <= mass * 0.75 m / 1 kg", gradient=slopes)
    found = jo.design.form(limit)
    assert found.gradients > 0 and study.counts["runs"] <= found.calls
    by_differences = jo.design.form(
        jo.design.limit_state(
            study, "last(way) <= mass * 0.75 m / 1 kg", step=1e-4, differences="central"
        )
    )
    assert found.beta == pytest.approx(by_differences.beta, abs=1e-6)
    # at the design point along the gradient: the residual is that of the tolerance
    np.testing.assert_allclose(found.u, by_differences.u, atol=1e-5)
    with pytest.raises(
        jo.design.LimitStateError, match=r"gradient has shape \(2,\), must be outcomes x param"
    ):
        jo.design.form(jo.design.limit_state(study, "last(way) <= 2", gradient=lambda x: x))


def test_exact_gradients_give_the_direction_to_rounding() -> None:
    study = of_block()
    limit = jo.design.limit_state(study, "last(way) <= 1.5 m", gradient=True)
    found = jo.design.form(limit)
    assert found.beta == pytest.approx(beta(1.5), rel=1e-9)
    share = (2 * 1.5 * SM) ** 2 / ((2 * 1.5 * SM) ** 2 + SF**2)
    # differences of 1e-3 deviations leave 2e-3, see above; the tolerance of FORM is 1e-6
    assert found.importance["mass"] == pytest.approx(share, abs=1e-5)


def test_points_that_fail_say_why() -> None:
    limit = jo.design.limit_state(of_block(sd=1.0), "last(way) <= 4 m")
    with pytest.raises(jo.design.LimitStateError, match=r"failed: body 'block': mass is -.* kg"):
        jo.design.monte_carlo(limit, samples=100)
    found = jo.design.monte_carlo(limit, samples=100, failed="count")
    assert found.broken == sum(found.reasons.values()) > 0
    assert all("must be a positive number" in reason for reason in found.reasons)
    assert "without a value" in repr(found)


FATIGUE = """
parameters:
  cycles: {value: 1e6, distribution: lognormal(cov=0.5)}
  scatter: {value: 1, distribution: lognormal(cov=0.3)}
  push: {value: 100 N, distribution: normal(sd=8 N)}
parts:
  rod:
    type: beam
    length: 400 mm
    section: {type: rectangle, width: 20 mm, height: 10 mm}
    material: S355
    elements: 1
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 0}
bodies: [{name: arm, part: rod, damping: 0.05}]
joints: [{type: fixed, name: clamp, a: ground.origin, b: arm.start}]
forces:
  - {type: force, name: push, marker: arm.end, vector: [0, 0, "${push}"],
     signal: {type: harmonic, frequency: 2 Hz}}
fatigue:
  curves: {steel: {S_D: 100 MPa, N_D: "${cycles}", k: 5, rule: elementary}}
  checks: [{body: arm, sn: steel, residue: repeat, sites: [e1.a.top]}]
simulation: {t_end: 1 s, solver: {type: ROS2, step: 5 ms}, output_step: 10 ms}
"""


@pytest.mark.filterwarnings("ignore:.*nothing depends on it")
def test_life_under_a_scattering_load_and_curve(tmp_path: Path) -> None:
    """Life is proportional to the cycles of the curve: of lognormal ones the index is exact."""
    path = tmp_path / "arm.yaml"
    path.write_text(FATIGUE)
    file = jo.read_model(path)
    cycles, scatter, _ = file.parameters
    curve = jo.study(file, ["cycles"], "life(arm)")
    life = float(curve([1e6])[0])
    medians, spreads = (1 / math.sqrt(1.25), 1 / math.sqrt(1.09)), (math.log(1.25), math.log(1.09))
    text = f"life(arm) >= {life / 5!r} s / scatter"
    limit = jo.design.limit_state(curve, text, parameters=[scatter])
    exact = math.log(5 * math.prod(medians)) / math.sqrt(sum(spreads))
    assert jo.design.form(limit).beta == pytest.approx(exact, abs=1e-6)
    # the load: stress is proportional to it but for the turns of bending, some 1e-4, and life to
    # its fifth power (k = 5)
    both = jo.study(file, ["cycles", "push"], "life(arm)")
    found = jo.design.form(jo.design.limit_state(both, f"life(arm) >= {life / 5!r} s"))
    assert found.x["cycles"] * (100 / found.x["push"]) ** 5 == pytest.approx(1e6 / 5, rel=1e-3)
    assert cycles.name == "cycles" and found.beta < math.log(5 * medians[0]) / spreads[0] ** 0.5


def test_what_makes_no_sense_is_said() -> None:
    study = of_block()
    for text, message in {
        "last(wy) <= 1": r"the study has no outcome 'last\(wy\)'",
        "last(way)": "a limit is an outcome, <= or >=, and a value",
        "last(way) <= 3 kg": r"3 kg \(a mass\) is not a bound for last\(way\), which is in m",
        "last(way) <= strength": "'strength'",
        "lost(way) <= 1": "no outcome 'lost'",
    }.items():
        with pytest.raises(InputError, match=message):
            jo.design.limit_state(study, text)
    fixed = jo.study(block, [jo.Parameter("mass", 2.0, unit="kg")], "m = mass", t_end=1.0)
    with pytest.raises(InputError, match="no parameter has a distribution"):
        jo.design.limit_state(fixed, "m <= 3")
    pair = {("mass", "force"): 1.2}
    with pytest.raises(InputError, match="correlation"):
        jo.design.limit_state(study, "last(way) <= 1", correlation=pair)
    with pytest.raises(InputError, match="parameter 'force' is also a parameter of the study"):
        jo.design.limit_state(study, "last(way) <= 1", parameters=parameters()[1:])
    with pytest.raises(InputError, match="no random variables are given, and the limit state"):
        jo.design.form(lambda x: x["a"])
    with pytest.raises(jo.design.DesignPointError, match="beyond 8"):
        jo.design.form(jo.design.limit_state(study, "last(way) >= 0.01 m"))
