"""Function `make_scene`: scene of a run, a model, a part, a mesh or modes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem
from jousto.fatigue.miner.damage_field import DamageField
from jousto.mechanism.mechanism import Mechanism
from jousto.mesh.mesh import Mesh
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.parts.part import Part
from jousto.reduction.reduced import ReducedPart
from jousto.scene.damage import add_damage
from jousto.scene.machine import measures_of, model_scene, run_scene
from jousto.scene.modes import machine_modes, part_modes
from jousto.scene.parts import mesh_scene, part_scene
from jousto.scene.scene import Scene
from jousto.simulation.modes.linear import MechanismModes
from jousto.simulation.results.solution import Solution

KINDS: tuple[tuple[type[Any], Callable[[Any], Scene]], ...] = (
    (Solution, run_scene),
    (Model, model_scene),
    (Mechanism, lambda mechanism: model_scene(compile(mechanism))),
    (MechanismModes, machine_modes),
    (ReducedPart, part_modes),
    (Part, part_scene),
    (Mesh, mesh_scene),
)
"""Types with scenes, and the functions that create them."""


@explained
def make_scene(thing: Any, *, damage: DamageField | Sequence[DamageField] = ()) -> Scene:
    """Return the scene of an object.

    Rows of a run are read from its results on demand, see `Motion`.

    Parameters
    ----------
    thing : Solution, Model, Mechanism, MechanismModes, ReducedPart, Part or Mesh
        Object to show: a run moves, a model or mechanism is at its start, modes and reduced parts
        vibrate.
    damage : DamageField or sequence of DamageField
        Damage of bodies of a run, which is shown over them.

    Raises
    ------
    InputError
        If the object has no visible shape, or the damage belongs to no body of it.
    """
    scene = next((make(thing) for kind, make in KINDS if isinstance(thing, kind)), None)
    if scene is None:
        names = [kind.__name__ for kind, _ in KINDS]
        known = f"{', '.join(names[:-1])} or {names[-1]}"
        message = f"a {type(thing).__name__} cannot be shown; give a {known}"
        raise InputError(Problem("view", message))
    fields = (damage,) if isinstance(damage, DamageField) else tuple(damage)
    if not fields:
        return scene
    bodies = add_damage(scene.bodies, fields)
    return replace(scene, bodies=bodies, measures=measures_of(bodies))
