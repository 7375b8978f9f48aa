"""Check of the arguments of `rbdo`, with all problems in one error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems, suggest
from jousto.design.reliability.inputs.transform import Transformation, transformation
from jousto.design.reliability.limit import Counted, LimitState, as_limit
from jousto.design.reliability.pma import METHODS as MEAN_VALUES
from jousto.design.reliability.targets.redesign import FAR, WHERE, Redesign

METHODS = ("sora", "pma", "ria")


def read_redesign(
    cost: Any,
    limits: Any,
    variables: Any,
    bounds: Any,
    beta: Any,
    start: Any,
    method: Any,
    inner: Any,
) -> Redesign:
    """Return the design problem of the arguments; raise InputError with all problems.

    Raises
    ------
    InputError
        With all problems of the arguments.
    """
    problems = Problems()
    if method not in METHODS:
        problems.add(WHERE, f"method is {method!r}, must be one of {', '.join(METHODS)}")
    if inner not in MEAN_VALUES:
        problems.add(WHERE, f"inner is {inner!r}, must be one of {', '.join(MEAN_VALUES)}")
    named = _limits(problems, limits)
    own = [one.variables for one in named.values() if one.variables is not None]
    if variables is None and not own:
        problems.add(WHERE, "no random variables are given, and the limit states have none")
        problems.raise_if_any()
    T = transformation(own[0] if variables is None else variables)
    boxes = _bounds(problems, bounds, T)
    given = _start(problems, start, boxes, T)
    targets = _targets(problems, beta, list(named))
    problems.raise_if_any()
    designs = list(boxes)
    low, high = (np.array([box[k] for box in boxes.values()]) for k in (0, 1))
    names = (*T.names, *(name for name in designs if name not in T.names))
    about = cost if isinstance(cost, LimitState) else as_limit(cost, "cost")
    width = np.where(np.isfinite(high - low), high - low, np.maximum(np.abs(given), 1.0))
    return Redesign(
        cost=Counted(about, designs),
        counted=[Counted(one, names) for one in named.values()],
        names=list(named),
        variables=T,
        designs=designs,
        low=low,
        high=high,
        start=given,
        scale=np.where(width > 0.0, width, 1.0),
        beta=targets,
    )


def _limits(problems: Problems, limits: Any) -> dict[str, LimitState]:
    if callable(limits) or isinstance(limits, LimitState):
        limits = [limits]
    if isinstance(limits, Mapping):
        pairs = list(limits.items())
    elif isinstance(limits, list | tuple):
        # functions without a name are numbered
        own = [as_limit(one).name if callable(one) else getattr(one, "name", "G") for one in limits]
        pairs = [
            (f"G{i + 1}" if name == "G" else name, one)
            for i, (name, one) in enumerate(zip(own, limits, strict=True))
        ]
    else:
        pairs = []
    if not pairs:
        problems.add(WHERE, f"limits is {limits!r:.60}, must be a dictionary of limit states")
    found: dict[str, LimitState] = {}
    for name, one in pairs:
        if not (isinstance(one, LimitState) or callable(one)):
            problems.add(
                WHERE, f"limits[{name!r}] is {one!r:.60}, must be a function or LimitState"
            )
        elif name in found:
            problems.add(WHERE, f"two limit states have the name {name!r}")
        else:
            state = as_limit(one, str(name))
            found[str(name)] = replace(state, name=str(name))
    return found


def _bounds(problems: Problems, bounds: Any, T: Transformation) -> dict[str, tuple[float, float]]:
    if not isinstance(bounds, Mapping) or not bounds:
        problems.add(WHERE, f"bounds is {bounds!r:.60}, must be a dictionary of two numbers each")
        return {}
    movable = {one.name for one in T.randoms}
    found = {}
    for name, pair in bounds.items():
        try:
            low, high = (float(x) for x in pair)
        except (TypeError, ValueError):
            problems.add(WHERE, f"bounds of {name!r} are {pair!r:.40}, must be two numbers")
            continue
        if not low < high:
            wrong = "crossed" if low > high else "equal" if low == high else "no numbers"
            problems.add(WHERE, f"bounds of '{name}' are {low:g} to {high:g}, they are {wrong}")
            continue
        if name in T.names and name not in movable:
            message = f"the mean of '{name}' is no parameter of such variables"
            problems.add(WHERE, message + "; those of Nataf have means")
            continue
        found[str(name)] = (low, high)
    return found


def _start(problems: Problems, start: Any, boxes: Any, T: Transformation) -> Array:
    means = {one.name: one.mean for one in T.randoms}
    if start is not None and not isinstance(start, Mapping):
        problems.add(WHERE, f"start is {start!r:.60}, must be a dictionary of numbers")
        start = None
    given = dict(start or {})
    for name in given:
        if name not in boxes:
            problems.add(WHERE, f"start has {name!r}, which has no bounds{suggest(name, boxes)}")
    out = []
    for name, (low, high) in boxes.items():
        value = given.get(name, means.get(name))
        if value is None:
            problems.add(WHERE, f"start needs a value for '{name}', which is not random")
            continue
        if not problems.number(WHERE, f"start of '{name}'", value, ""):
            continue
        if not low <= value <= high:
            whose = "start" if name in given else "mean"
            message = f"{whose} of '{name}' is {value:g}, outside of its bounds {low:g} to {high:g}"
            problems.add(WHERE, message)
        out.append(float(value))
    return np.array(out)


def _targets(problems: Problems, beta: Any, names: list[str]) -> Array:
    if isinstance(beta, Mapping):
        for name in beta:
            if name not in names:
                problems.add(WHERE, f"beta has {name!r}{suggest(name, names)}")
        for name in names:
            if name not in beta:
                problems.add(WHERE, f"beta has no target for '{name}'")
        values = [beta.get(name, 1.0) for name in names]
    else:
        values = [beta] * len(names)
    out = []
    for value in values:
        before = len(problems.found)
        problems.positive(WHERE, "beta", value, "")
        if len(problems.found) > before:
            return np.ones(len(names))
        if value > FAR:
            problems.add(
                WHERE, f"beta is {value:g}, above {FAR:g} the probability is too small for a double"
            )
        out.append(float(value))
    return np.array(out)
