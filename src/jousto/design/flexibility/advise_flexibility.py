"""advise_flexibility: which bodies of a machine must be flexible."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, JoustoError, Problem, Problems, suggest
from jousto.design.flexibility.body_advice import BodyAdvice, ModesAdvice
from jousto.design.flexibility.comparison import Comparison
from jousto.design.flexibility.expected import Expected, expected_readings
from jousto.design.flexibility.flexibility_advice import FlexibilityAdvice
from jousto.design.flexibility.hot_spot_readings import CheckRule, SlopeRule
from jousto.design.flexibility.sensor_losses import sensor_losses
from jousto.design.flexibility.stress_losses import stress_losses
from jousto.design.flexibility.variant_runs import Settings, VariantRun, run_variant
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.body_variants import with_modes, with_rigid_bodies
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.state import State

WHERE = "advise_flexibility"


@dataclass(frozen=True, eq=False)
class Task:
    """What is to be advised, with all arguments checked."""

    mechanism: Mechanism
    settings: Settings
    bodies: tuple[str, ...]
    wanted: frozenset[str]
    limit: float
    life_limit: float
    rules: Mapping[str, Any]
    modes: bool


@explained
def advise_flexibility(
    machine: Any,
    t_end: float | None = None,
    *,
    bodies: Sequence[str] | str | None = None,
    readings: Sequence[str] | str | None = None,
    limit: float = 0.02,
    life_limit: float = 0.1,
    slope: float | None = None,
    from_rigid: bool = False,
    modes: bool = True,
    **how: Any,
) -> FlexibilityAdvice:
    """Return what each reading loses with each flexible body rigid in turn, and what that saves.

    Readings y are all values of all sensors, and the signed von Mises stress at the hot spot of
    each flexible body. With y_r of the run with the rigid body: ``e_inf = max |y_r - y| / (max y -
    min y)``, the change of the peak ``max |y_r| / max |y| - 1``, the shift in time that minimises
    e_inf, and the ratio of the rainflow damage. The stress of a rigid body is that of its static
    deformation under its loads with inertia relief, ``S K^+ (F - M a)``; only its vibration is
    lost.

    Each loss is estimated as well, from the rigid run and the elastic body alone: its static
    deformation as the joints hold it, and its vibration under the history of its loads. A body is
    "rigid" if the estimate and the measured loss of all readings are within the limits.

    Parameters
    ----------
    machine : Mechanism or ModelFile
        Machine with flexible bodies; a model file (`jo.read_model`) has its end time and
        solver, and fatigue checks for the lives.
    t_end : float, optional
        End of the runs, s; None takes that of the model file.
    bodies : str or sequence of str, optional
        Flexible bodies to be advised; None takes all.
    readings : str or sequence of str, optional
        Sensors, components such as ``tip.x``, or ``stress BODY``; None takes all.
    limit : float
        Largest loss of a reading / its range. A reading without a range is judged by its peak.
    life_limit : float
        Largest deviation of the damage ratio from 1.
    slope : float, optional
        Slope m of the S-N curve for the damage of bodies without a fatigue check; None judges no
        life of these.
    from_rigid : bool
        Whether to simulate only the machine with all these bodies rigid, and estimate what each
        reading would gain with one of them flexible.
    modes : bool
        Whether to look for modes to be left out by their strain energy as well: a further run for
        each body that has some.
    **how
        ``solver`` and ``output_step`` of `simulate`; without them those of the model file.

    Returns
    -------
    FlexibilityAdvice
        Printed as a table with recommendations.

    Raises
    ------
    InputError
        With all problems: no flexible body (and which data the rigid ones lack), unknown bodies or
        readings, wrong limits, no end time.
    SimulationError
        If the run of the given machine fails. A failing run with a rigid body is a result.
    """
    task = _checked(
        machine,
        t_end,
        (bodies, readings),
        {"limit": limit, "life_limit": life_limit, "slope": slope},
        how,
        modes and not from_rigid,
    )
    if from_rigid:
        return _from_rigid(task)
    full = run_variant(task.mechanism, task.settings, quiet=False)
    found = tuple(_rigid_in_turn(task, full, body) for body in task.bodies)
    return FlexibilityAdvice(task.mechanism.name, found, False, full.steps, full.seconds)


def _rigid_in_turn(task: Task, full: VariantRun, body: str) -> BodyAdvice:
    """Return the advice on one body, from the full run and the run with this body rigid."""
    modes = _modes_left_out(task, full, body) if task.modes else None
    limits: dict[str, Any] = {"limit": task.limit, "life_limit": task.life_limit, "modes": modes}
    try:
        variant = with_rigid_bodies(task.mechanism, [body])
        simple = run_variant(variant.mechanism, task.settings)
    except JoustoError as error:
        why = f"the run with the rigid body fails: {error}"
        return BodyAdvice(body, (), failed=why, **limits)
    expected, failed = _expected(full.model, full.arguments["state"], simple, body)
    comparison = Comparison(full, simple, expected, task.rules, task.wanted)
    return _advice(task, comparison, body, failed, limits)


def _from_rigid(task: Task) -> FlexibilityAdvice:
    """Return the advice from the run of the rigid machine alone."""
    rigid = with_rigid_bodies(task.mechanism, task.bodies)
    simple = run_variant(rigid.mechanism, task.settings, quiet=False)
    found = []
    for body in task.bodies:
        others = [name for name in task.bodies if name != body]
        limits: dict[str, Any] = {"limit": task.limit, "life_limit": task.life_limit}
        mechanism = with_rigid_bodies(task.mechanism, others).mechanism
        one = Task(**vars(task) | {"mechanism": mechanism})
        expected, failed = _from_parts(mechanism, task.settings, simple, body)
        comparison = Comparison(None, simple, expected, task.rules, task.wanted)
        found.append(_advice(one, comparison, body, failed, limits))
    name = task.mechanism.name
    return FlexibilityAdvice(name, tuple(found), True, simple.steps, simple.seconds)


def _from_parts(
    mechanism: Mechanism, settings: Settings, simple: VariantRun, body: str
) -> tuple[Expected | None, str]:
    """Return the estimate for a body that was not simulated flexible, or why there is none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            model = compile(mechanism)
            begin = initial_state(model, start=settings.start)
        except JoustoError as error:
            return None, f"no estimate: {error}"
        return _expected(model, begin, simple, body)


def _expected(
    full: Model, begin: State | None, simple: VariantRun, body: str
) -> tuple[Expected | None, str]:
    """Return the estimate for a body from the run with the rigid one, or why there is none."""
    place = [one.name for one in full.bodies].index(body)
    try:
        return expected_readings(full, begin, simple, place), ""
    except (JoustoError, np.linalg.LinAlgError) as error:
        return None, f"no estimate: {error}"


def _advice(
    task: Task, comparison: Comparison, body: str, failed: str, limits: Mapping[str, Any]
) -> BodyAdvice:
    """Return the advice on a body from compared runs."""
    expected = comparison.expected
    readings = (*sensor_losses(comparison), *stress_losses(comparison, task.mechanism))
    facts: dict[str, Any] = {}
    if expected is not None:
        flexible = next(one for one in task.mechanism.bodies if one.name == body)
        facts = {
            "first": expected.first / (2.0 * np.pi),
            "highest": expected.highest / (2.0 * np.pi),
            "ratio": expected.ratio,
            "bound": expected.bound,
            "amplification": expected.amplification,
            "slower": expected.slower,
            "impact": expected.impact,
            "deflection": _deflection(flexible, expected),
        }
    simple = comparison.simple
    cost: dict[str, Any] = {"steps": simple.steps, "seconds": simple.seconds}
    return BodyAdvice(body, readings, failed=failed, **facts, **cost, **limits)


def _deflection(body: Any, expected: Expected) -> float:
    """Return the largest static displacement of a node relative to the chord of the body, m."""
    p = expected.deformation(body.name)
    moved = np.einsum("kcj,tj->tkc", body.reduced.modes, p)
    return float(np.linalg.norm(moved, axis=2).max(initial=0.0))


# -- modes ----------------------------------------------------------------------------------


def _modes_left_out(task: Task, full: VariantRun, body: str) -> ModesAdvice:
    """Return the energy of the modes of a body, and the loss without the smallest ones.

    Modes are left out while their energy together is below ``limit^2`` of that of the body: the
    displacement and the stress in them are below the limit then.
    """
    model = next(one for one in full.model.bodies if one.name == body)
    p = full.run.coordinates(body)[:, 7:]
    energy = (p**2).mean(axis=0) * np.real(model.K)
    share = energy / (energy.sum() or 1.0)
    order = np.argsort(share, kind="stable")
    out = order[np.cumsum(share[order]) < task.limit**2][: model.n - 1]
    kept = tuple(int(k) for k in range(model.n) if k not in out)
    if len(kept) == model.n:
        return ModesAdvice(share, kept)
    try:
        variant = with_modes(task.mechanism, {body: kept})
        simple = run_variant(variant.mechanism, task.settings)
    except JoustoError as error:
        return ModesAdvice(share, kept, failed=f"the run fails: {error}")
    comparison = Comparison(full, simple, None, task.rules, task.wanted)
    readings = (*sensor_losses(comparison), *stress_losses(comparison, task.mechanism))
    return ModesAdvice(share, kept, readings, simple.steps, simple.seconds)


# -- arguments ------------------------------------------------------------------------------


def _checked(
    machine: Any,
    t_end: float | None,
    names: tuple[Any, Any],
    limits: Mapping[str, Any],
    how: Mapping[str, Any],
    modes: bool,
) -> Task:
    """Return the task of the arguments; raise an error with all problems."""
    problems = Problems()
    mechanism = getattr(machine, "mechanism", machine)
    if not isinstance(mechanism, Mechanism):
        message = f"machine is {machine!r}, must be a Mechanism or a model file (read_model)"
        raise InputError(Problem(WHERE, message))
    for name, value in limits.items():
        if value is not None:
            problems.positive(WHERE, name, value, "")
        if name != "slope" and isinstance(value, int | float) and value >= 1.0:
            message = f"{name} is {value:g}, {100 * value:g} %; give a share such as 0.05 or '5 %'"
            problems.add(WHERE, message)
    for name in how:
        if name not in ("solver", "output_step"):
            message = f"there is no argument {name!r}{suggest(name, ['solver', 'output_step'])}"
            problems.add(WHERE, message)
    bodies = _bodies(problems, mechanism, names[0])
    wanted = _readings(problems, mechanism, names[1])
    settings = _settings(problems, machine, t_end, how)
    problems.raise_if_any()
    assert settings is not None
    checks = getattr(getattr(machine, "fatigue", None), "checks", ())
    rules: dict[str, Any] = {check.body: CheckRule(check) for check in checks}
    if limits["slope"] is not None:
        rules[""] = SlopeRule(float(limits["slope"]))
    numbers = (float(limits["limit"]), float(limits["life_limit"]))
    return Task(mechanism, settings, bodies, wanted, *numbers, rules, modes)


def _bodies(problems: Problems, mechanism: Mechanism, given: Any) -> tuple[str, ...]:
    """Return the bodies to be advised; report unknown ones, and a machine without flexible ones."""
    flexible = [one.name for one in mechanism.bodies if isinstance(one, FlexibleBody)]
    names = [given] if isinstance(given, str) else list(given or flexible)
    rigid = [one.name for one in mechanism.bodies if one.name not in flexible]
    if not flexible:
        problems.add(
            f"mechanism '{mechanism.name}'",
            f"has no flexible body, and its rigid bodies ({', '.join(rigid)}) have no elastic "
            "data: neither stiffness nor modes. Give one of them a part (a beam, a mesh with a "
            "material, or the modes of another program): part: NAME in the model file, "
            "FlexibleBody(name, reduce(part, method)) in Python; then also from_rigid=True "
            "(--from-rigid) works, which simulates only the rigid machine",
        )
        return ()
    for name in names:
        if name in rigid:
            message = "is rigid and has no elastic data; give it a part"
            problems.add(f"body '{name}'", message)
        elif name not in flexible:
            problems.add("bodies", f"no flexible body '{name}'{suggest(str(name), flexible)}")
    return tuple(dict.fromkeys(names))


def _readings(problems: Problems, mechanism: Mechanism, given: Any) -> frozenset[str]:
    """Return the names of readings; report unknown ones."""
    names = [given] if isinstance(given, str) else list(given or ())
    known = {f"stress {one.name}" for one in mechanism.bodies if isinstance(one, FlexibleBody)}
    for sensor in mechanism.sensors:
        known |= {sensor.name, *(f"{sensor.name}.{one}" for one in sensor.components)}
    for name in names:
        if name not in known:
            problems.add("readings", f"no reading '{name}'{suggest(str(name), sorted(known))}")
    return frozenset(names)


def _settings(
    problems: Problems, machine: Any, t_end: Any, how: Mapping[str, Any]
) -> Settings | None:
    """Return the arguments of the runs; report a missing end."""
    simulation = getattr(machine, "simulation", None)
    end = t_end if t_end is not None else getattr(simulation, "t_end", None)
    if end is None:
        problems.add(WHERE, "no end time: give t_end, or simulation: {t_end: ...} in the file")
        return None
    problems.positive(WHERE, "t_end", end, "s")
    given = {} if simulation is None else simulation.given()
    start = None if simulation is None else simulation.start
    return Settings(end, {**given, **how}, start)
