"""state_at: state of a model at positions of its tree."""

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

FITS = 1e-8  # largest gap of a joint over the size of the machine, or rad, after assembly


@explained
def state_at(tree: Tree, model: Model, q: ArrayLike) -> State:
    """Return the state of a model at rest at positions of its tree, for a run or an analysis.

    Parameters
    ----------
    tree : Tree
        Tree of the mechanism of the model.
    model : Model
        From `compile`.
    q : (nq,) array_like
        Positions of the tree with closed loops, such as those of `inverse_kinematics`.

    Returns
    -------
    State
        State at time 0, for ``simulate(model, t_end, state=...)`` and other functions with a
        state. Flexible bodies are undeformed. Angles include the revolutions of q.

    Raises
    ------
    InputError
        If a joint is open or beyond its limits, a drive prescribes another position, or the bodies
        of tree and model differ.

    Examples
    --------
    ``found = jo.robots.inverse_kinematics(tree, "tool", (0.5, 0, 0.6))``, then
    ``jo.simulate(model, 2.0, state=jo.robots.state_at(tree, model, found.q))``
    """
    _check_kinds(tree, model)
    _check_limits(tree, q)
    poses = tree.forward_kinematics(q)
    # bodies of the model must be in the tree; the base of a robot is in the tree only
    missing = [body.name for body in model.bodies if body.name not in poses]
    if missing:
        message = f"the tree has no body {missing[0]!r} of {model!r}; give the tree of this model"
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
    """Raise an error for arguments of wrong types."""
    problems = Problems()
    if not isinstance(tree, Tree):
        problems.add("state_at", f"tree is {tree!r}, must be a Tree")
    if not isinstance(model, Model):
        problems.add("state_at", f"model is {model!r}, must be a Model from compile")
    problems.raise_if_any()


def _check_limits(tree: Tree, q: ArrayLike) -> None:
    """Raise an error for positions outside their limits, at which stops would act."""
    problems, values = Problems(), dict(zip(tree.positions, np.ravel(np.asarray(q)), strict=False))
    for name, low, high in zip(tree.velocities, tree.lower, tree.upper, strict=True):
        x = values.get(name, low)
        if not low - FITS <= x <= high + FITS:
            problems.add("state_at", f"{name} is {x:g}, outside its limits {low:g} and {high:g}")
    problems.raise_if_any()


def _check(model: Model, engine: Engine) -> None:
    """Raise an error for open joints and for drives at another position."""
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
                f"begins {gap:.3g} (m or rad) away from these positions; change its signal, or "
                "remove the drive"
            )
        else:
            sentence = (
                f"is open by {gap:.3g} (m or rad) at these positions; give positions with closed "
                "loops, such as those of inverse_kinematics"
            )
        problems.add(place(joint), sentence)
    problems.raise_if_any()
