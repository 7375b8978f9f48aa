"""Accelerations of a body in a run, and the amplitudes of its residual stress."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.voigt import PAIRS
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.recovery.model_of_run import check_model
from jousto.recovery.shape import find_body, rotation_matrices
from jousto.reduction.fields.residual_stress import ResidualStress
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import put


def accelerations(run: Solution, model: Model | None = None) -> Array:
    """Return the accelerations (nt, nv) of a run, ``[R'' w' p'']`` body after body.

    Parameters
    ----------
    run : Solution
    model : Model, optional
        Model of the run, for exact accelerations by the engine. None takes central differences
        of the stored velocities, with an error proportional to the square of the output step.

    Raises
    ------
    InputError
        If the model is not that of the run, or there are fewer than three instants.
    """
    if model is None:
        if run.nt < 3:
            message = (
                f"accelerations need three stored instants, there are {run.nt}; give the model"
            )
            raise InputError(Problem(run.where, message))
        return np.asarray(np.gradient(run.v, run.time, axis=0, edge_order=2))
    check_model(run, model, run.where)
    engine, out = Engine(model), np.empty((run.nt, model.nv))
    for k, state in enumerate(run.each_state()):
        put(engine, replace(state, work=None), run.where)  # kinematics does not use the work
        out[k] = engine.accelerations()[0]
    return out


def amplitudes(
    run: Solution,
    body: str,
    residual: ResidualStress,
    model: Model | None = None,
    loads: Mapping[str, Any] | None = None,
) -> Array:
    """Return the amplitudes (nt, m) of the columns of a residual stress.

    Parameters
    ----------
    run : Solution
    body : str
    residual : ResidualStress
        Residual stress of the part of the body.
    model : Model, optional
        See `accelerations`.
    loads : mapping of str to (nt,) array, number or str
        History of each named load, in units of that load; a str is the name of a sensor of one
        component.

    Raises
    ------
    InputError
        If a load is missing, unknown or of another length.
    """
    where, problems, given = f"stress of '{body}'", Problems(), dict(loads or {})
    shape = find_body(run, body)
    nt, n = run.nt, shape.n
    a = accelerations(run, model)[:, shape.v_offset : shape.v_offset + 6 + n]
    q = run.coordinates(body)
    w = run.v[:, shape.v_offset + 3 : shape.v_offset + 6]
    gravity = np.asarray(run.attributes.get("gravity", np.zeros(3)), dtype=np.float64)
    A = rotation_matrices(q[:, 3:7])
    felt = np.einsum("tij,ti->tj", A, a[:, :3] - gravity)
    spin = np.stack([w[:, i] * w[:, j] for i, j in PAIRS], axis=1)
    columns = [felt, a[:, 3:6], spin, a[:, 6:]]
    for name in residual.loads:
        if name not in given:
            message = f"the history of load '{name}' is missing: loads={{{name!r}: ...}}"
            problems.add(where, message)
            continue
        value = given.pop(name)
        if isinstance(value, str):
            value = run[value].reshape(nt, -1)
            value = value[:, 0] if value.shape[1] == 1 else value
        values = np.full(nt, value) if np.ndim(value) == 0 else value
        history = problems.array(where, f"load '{name}'", values, (nt,))
        if history is not None:
            columns.append(history[:, None])
    for name in given:
        problems.add(
            where, f"no load '{name}' in its residual stress{suggest(name, residual.loads)}"
        )
    problems.raise_if_any()
    return np.concatenate(columns, axis=1)
