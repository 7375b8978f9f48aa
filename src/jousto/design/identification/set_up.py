"""What `identify` is given: measurements, machines and unknowns, checked before the search."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problems
from jousto.design.identification.bench import Bench
from jousto.design.identification.experiment import Experiment
from jousto.design.identification.modal import Modal, make_modal_bench
from jousto.design.identification.prediction import make_bench
from jousto.design.identification.residuals import Compared, Residuals
from jousto.design.identification.search import LOSSES
from jousto.design.identification.unknowns import Unknown, unknowns as unknowns_of
from jousto.design.identification.values import Values, make_values_bench
from jousto.design.studies.case import Settings
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.sources import choose_parameters, source_of
from jousto.measurement.gauges.record import Record

Measurement = Experiment | Values | Modal


def set_up(
    model: Any,
    parameters: Any,
    experiments: Any,
    check: Any,
    loss: str,
    solver: Any,
    starts: Any,
    workers: Any,
) -> tuple[Residuals, Residuals | None, tuple[bool, ...]]:
    """Return the residuals of the fit and of the check, and which noises are estimated."""
    problems = Problems()
    if loss not in LOSSES:
        problems.add("identify", f"loss is {loss!r}, must be one of {', '.join(LOSSES)}")
    for name, value in (("starts", starts), ("workers", workers)):
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            problems.add("identify", f"{name} is {value!r}, must be a whole number from 1 on")
    fitted = _experiments(problems, experiments, "experiments")
    checked = _experiments(problems, check, "check")
    if not fitted and not problems.found:
        problems.add("identify", "no experiment; give a record")
    own: tuple[Parameter, ...] = ()
    try:
        source = source_of(model, Settings()) if model is not None else None
        if source is None:
            own = tuple([parameters] if isinstance(parameters, Parameter) else parameters or ())
        else:
            own = choose_parameters(source, parameters)
    except InputError as error:
        problems.found += error.problems
    channels = tuple(dict.fromkeys(p for one in fitted for p in one.free))
    names = [p.name for p in (*own, *channels)]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            problems.add(f"parameter {name!r}", "is the name of two unknowns")
    for name in dict.fromkeys(p.name for one in checked for p in one.free):
        if name not in names:
            message = "is sought for a channel of a check record, which is never fitted"
            problems.add(f"parameter {name!r}", message)
    problems.raise_if_any()
    sought = unknowns_of(problems, (*own, *channels))
    rooms = _benches(problems, fitted, model, own, solver, workers)
    used = {int(k) for bench in rooms for k in bench.places}
    for k, parameter in enumerate(own):
        if k not in used:
            message = "is unused: no argument of the function, parameter of the file or input"
            problems.add(f"parameter {parameter.name!r}", f"{message} has its name")
    problems.raise_if_any()
    residuals, estimated = _compare(problems, rooms, sought)
    n, p = sum(residuals.sizes), len(sought)
    if n < p:
        problems.add("identify", f"{p} unknown numbers, but {n} values")
    problems.raise_if_any()
    checks = None
    if checked:
        spare = _benches(problems, checked, model, own, solver, workers)
        checks, _ = _compare(problems, spare, sought)
        problems.raise_if_any()
    return residuals, checks, estimated


def _experiments(problems: Problems, given: Any, what: str) -> list[Measurement]:
    """Return experiments from experiments, values, records and paths."""
    if isinstance(given, Experiment | Values | Modal | Record | str | Path):
        given = [given]
    found: list[Measurement] = []
    try:
        for one in given:
            found.append(one if isinstance(one, Experiment | Values | Modal) else Experiment(one))
    except TypeError:
        problems.add(
            "identify", f"{what} is {given!r:.60}, must be an Experiment, a Record or a path"
        )
    except InputError as error:
        problems.found += error.problems
    return found


def _benches(
    problems: Problems,
    given: Sequence[Measurement],
    model: Any,
    parameters: Sequence[Parameter],
    solver: Any,
    workers: int,
) -> tuple[Bench, ...]:
    """Return the benches of measurements, or raise the error of all problems."""
    found: list[Bench | None] = []
    for one in given:
        if isinstance(one, Values):
            found.append(make_values_bench(problems, one, model, parameters))
        elif isinstance(one, Modal):
            found.append(make_modal_bench(problems, one, model, parameters))
        else:
            found.append(make_bench(problems, one, model, parameters, solver, workers))
    problems.raise_if_any()
    return tuple(bench for bench in found if bench is not None)


def _compare(
    problems: Problems, benches: Sequence[Bench], sought: tuple[Unknown, ...]
) -> tuple[Residuals, tuple[bool, ...]]:
    """Return the residuals of benches, from runs at the start values."""
    theta = np.array([own.start for own in sought])
    compared: list[Compared] = []
    estimated: list[bool] = []
    for k, bench in enumerate(benches):
        (result,) = bench.results([theta])
        if isinstance(result, Exception):
            values = ", ".join(f"{own.name} {own.start:.6g}" for own in sought)
            text = " / ".join(str(result).splitlines())
            problems.add(bench.name, f"fails at {values}: {text}")
            continue
        for about in bench.compare(problems, result):
            estimated.append(about.sd is None)
            sd = about.sd
            if sd is None:
                sd = np.full(len(about.y), float(np.std(about.y)))
            compared.append(Compared(k, about, sd))
    return Residuals(tuple(benches), tuple(compared), sought), tuple(estimated)
