"""Named constants of a model file that can change during a run of an exported machine."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import InputError, Problems
from jousto.export.constants import Constants, constants
from jousto.export.ports import Named, refuse
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.native.native import Engine

SHARE = 1e-2  # relative change of a constant in the test of its effects
STRAIGHT = 1e-9  # relative deviation below which an effect is linear


def named_constants(file: Any, model: Model) -> tuple[Named, ...]:
    """Return the parameters of a model file that affect tunable constants only.

    Each parameter is increased and decreased: only gravity and data of forces, frictions and
    signals may change, and linearly. A length or a mass, on which positions and inertia depend, is
    excluded, and so is a parameter with a quadratic effect. Parameters of parts are not tested,
    since parts would be reduced again.

    Parameters
    ----------
    file : ModelFile
        From `read_model`.
    model : Model
        Model compiled from its mechanism.

    Raises
    ------
    InputError
        If the arguments are not a model file and its model, or the model cannot be exported.
    """
    problems, given = Problems(), dict[str, Any](model=model)
    if not hasattr(file, "variants") or not hasattr(file, "parameters"):
        problems.add("named_constants", f"file is {file!r:.80}, must come from read_model")
    if not isinstance(given["model"], Model):
        problems.add("named_constants", f"model is {model!r:.80}, must come from compile")
    problems.raise_if_any()
    refuse(model)
    here, kept = constants(Engine(model)), dict[Any, Any]()
    core = "joint" if model.links else "maximal"
    found = []
    made_of = in_parts(file.variants.document.data) if file.parameters else set()
    for parameter in file.parameters:
        if parameter.name in made_of:
            continue
        step = SHARE * abs(parameter.value) or SHARE
        sides = []
        for value in (parameter.value + step, parameter.value - step):
            other = _variant(file, {parameter.name: value}, kept, core)
            if other is not None and _alike(other, model, here):
                sides.append(other[1].tunable)
        links = _links(here.tunable, sides, parameter.value, step) if len(sides) == 2 else ()
        if links:
            named = (parameter.name, parameter.unit, float(parameter.value), parameter.bounds)
            found.append(Named(*named, links))
    return tuple(found)


def in_parts(data: Mapping[str, Any]) -> set[str]:
    """Return the names in expressions of the parts of a file, and the names on which they depend.

    Examples
    --------
    >>> parts = {"rod": {"length": "${2 * l}"}}
    >>> sorted(in_parts({"parameters": {"l": "${a + 1 m}", "a": 1.0, "k": 2.0}, "parts": parts}))
    ['a', 'l', 'm']
    """
    parameters = data.get("parameters") or {}
    found: set[str] = set()
    new = _names(data.get("parts"))
    while new:
        found |= new
        new = {x for name in new for x in _names(parameters.get(name))} - found
    return found


def _names(value: Any) -> set[str]:
    """Return the names in the expressions of a value."""
    inside = re.findall(r"\$\{([^}]*)\}", str(value))
    return {name for text in inside for name in re.findall(r"[A-Za-z_]\w*", text)}


def _variant(
    file: Any, values: Mapping[str, float], kept: dict[Any, Any], core: str
) -> tuple[Model, Constants] | None:
    """Return the machine with other values; None for invalid values."""
    try:
        model = compile(file.variants.make(values, kept)[0], core=core)
        return model, constants(Engine(model))
    except InputError:
        return None


def _alike(other: tuple[Model, Constants], model: Model, here: Constants) -> bool:
    """Return whether a variant differs in tunable constants only."""
    there, found = other
    return (
        found.fixed == here.fixed
        and found.places == here.places
        and np.array_equal(there.q0, model.q0)
        and np.array_equal(there.v0, model.v0)
    )


def _links(
    here: NDArray[np.float64], sides: list[NDArray[np.float64]], value: float, step: float
) -> tuple[tuple[int, float, float], ...]:
    """Return index, factor and offset of each changed constant; empty if one is not linear."""
    above, below = sides
    moved = np.flatnonzero((above != here) | (below != here))
    factor = (above - below) / (2.0 * step)
    bent = np.abs(above + below - 2.0 * here)
    if np.any(
        bent[moved] > STRAIGHT * np.maximum(np.abs(here[moved]), np.abs(above - below)[moved])
    ):
        return ()
    return tuple((int(i), float(factor[i]), float(here[i] - factor[i] * value)) for i in moved)
