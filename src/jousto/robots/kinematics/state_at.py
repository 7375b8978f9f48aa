"""Posed: the state of a model at positions of its tree."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.rotations import euler_parameters
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.rank.redundancy import is_drive, place
from jousto.robots.kinematics.tree import Tree
from jousto.simulation.state import State, put, take

FITS = 1e-8  # of the size of the machine, or rad: what assembly and rounding leave


@explained
def state_at(tree: Tree, model: Model, q: ArrayLike) -> State:
    """Return the state of a model at rest at positions of its tree, to start from.

    Parameters
    ----------
    tree : Tree
        Of the mechanism that the model was compiled from.
    model : Model
        From `compile`.
    q : (nq,) array_like
        Positions of the tree at which loops are closed, as from `inverse_kinematics`.

    Returns
    -------
    State
        At time 0, for ``simulate(model, t_end, state=...)`` and all that takes a state. Flexible
        bodies are undeformed. Angles count whole turns as q does.

    Raises
    ------
    InputError
        If a joint is open or beyond its limits, a drive asks for another position, or the model is
        of other bodies.

    Examples
    --------
    ``found = jo.robots.inverse_kinematics(tree, "tool", (0.5, 0, 0.6))``, then
    ``jo.simulate(model, 2.0, state=jo.robots.state_at(tree, model, found.q))``
    """
    _check_kinds(tree, model)
    _check_limits(tree, q)
    poses = tree.forward_kinematics(q)
    # the base of a robot is no body of its mechanism
    missing = [body.name for body in model.bodies if body.name not in poses]
    if missing:
        message = f"the tree has no body {missing[0]!r} of {model!r}; give the tree of its own"
        raise InputError(Problem("state_at", message))
    there, angles = np.zeros(model.nq), tree.angles(q)
    for body in model.bodies:
        there[body.iq : body.iq + 3] = poses[body.name].r
        there[body.iq + 3 : body.iq + 7] = euler_parameters(poses[body.name].A)
    turn = [angles.get(c.name, 0.0) for c in model.coordinates if c.kind == "angle"]
    engine = Engine(model)
    put(engine, State(there, np.zeros(model.nv), engine.lam, turn=np.array(turn)), "state_at")
    _check(model, engine)
    engine.assemble()
    engine.accelerations()
    return take(engine)


def _check_kinds(tree: Any, model: Any) -> None:
    """Refuse what is no tree and no model."""
    problems = Problems()
    if not isinstance(tree, Tree):
        problems.add("state_at", f"tree is {tree!r}, must be a Tree")
    if not isinstance(model, Model):
        problems.add("state_at", f"model is {model!r}, must be a Model from compile")
    problems.raise_if_any()


def _check_limits(tree: Tree, q: ArrayLike) -> None:
    """Refuse positions outside limits: stops would throw the machine back."""
    problems, values = Problems(), dict(zip(tree.positions, np.ravel(np.asarray(q)), strict=False))
    for name, low, high in zip(tree.velocities, tree.lower, tree.upper, strict=True):
        x = values.get(name, low)
        if not low - FITS <= x <= high + FITS:
            problems.add("state_at", f"{name} is {x:g}, outside its limits {low:g} and {high:g}")
    problems.raise_if_any()


def _check(model: Model, engine: Engine) -> None:
    """Refuse open joints and drives that are elsewhere."""
    problems = Problems()
    gaps = np.abs(engine.constraints()[0])
    for joint in model.joints:
        rows = slice(joint.row, joint.row + joint.rows)
        gap = float(gaps[rows].max(initial=0.0))
        far = float((gaps * engine.row_metres)[rows].max(initial=0.0))
        if joint.lock >= 0 or far <= FITS * model.size:
            continue
        if is_drive(joint):
            sentence = (
                f"begins {gap:.3g} (m or rad) from these positions; let its signal begin there, or "
                "leave the drive out"
            )
        else:
            sentence = (
                f"is open by {gap:.3g} (m or rad) at these positions; take positions that "
                "inverse_kinematics has reached"
            )
        problems.add(place(joint), sentence)
    problems.raise_if_any()
