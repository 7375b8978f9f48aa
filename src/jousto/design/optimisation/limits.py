"""Limits of an optimisation: stress, displacement, life and frequency.

The ratio of a value to its limit is 1 at the limit.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import AnyField, Field, Item, Text, field
from jousto.base.numbers import Positive, Whole
from jousto.base.rotations import Direction
from jousto.design.optimisation.elastic import Elastic
from jousto.fatigue.cycles.rainflow import rainflow
from jousto.fatigue.miner.damage import _sum, reference
from jousto.materials.strength.mean_stress import MeanStress
from jousto.materials.strength.sn import SN
from jousto.recovery.fields.criteria import check_criterion, evaluate

LEAST = 1e-30
"""Damage of a place without cycles: positive, so that its root has a derivative."""


class Criteria(Field[Any, Any]):
    """Type of fields: a stress criterion such as "von-mises" or "s11"."""

    form = "text"
    noun = "str or Plane"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the criterion, or report an unknown one."""
        try:
            return check_criterion(value, where=where)
        except InputError as error:
            problems.found.extend(error.problems)
            return value


class Places(Field[Any, "tuple[str, ...] | None"]):
    """Type of fields: names of stress places of the part; None for all."""

    form = "texts"
    noun = "sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names as a tuple, or report wrong ones."""
        found = (value,) if isinstance(value, str) else value
        found = tuple(found) if isinstance(found, Iterable) else ()
        if not found or not all(isinstance(word, str) for word in found):
            problems.add(where, f"{self.name} is {value!r}, must be names of places")
        return found


class Limit(Declared, section="limits"):
    """Base class of all limits."""

    kind = "limit"

    @property
    def label(self) -> str:
        """Limited quantity, for messages."""
        raise NotImplementedError


class BodyLimit(Limit):
    """Base class of limits on one body that follow from its displacements."""

    body: Text = field("Name of the body")

    def places(self, body: Elastic) -> tuple[str, ...]:
        """Return the names of the limited places."""
        raise NotImplementedError

    def rows(self, body: Elastic, shapes: Array) -> Array:
        """Return the limited quantity (places, components, nc) for displacements (ndof, nc)."""
        raise NotImplementedError

    def ratios(self, rows: Array, y: Array) -> Array:
        """Return value / limit (places, nt) at coordinates y (nc, nt)."""
        raise NotImplementedError


class PlacesLimit(BodyLimit):
    """Base class of limits on the stress at places."""

    sites: Places = field("Places of the part's stress; all if None", default=None, kw_only=True)

    def places(self, body: Elastic) -> tuple[str, ...]:
        """Return the names of the limited places."""
        return self.sites or tuple(stress_of(body).sites)

    def rows(self, body: Elastic, shapes: Array) -> Array:
        """Return the stress (ns, 6, nc) of displacements (ndof, nc)."""
        stress = stress_of(body)
        chosen = stress if self.sites is None else stress.select(self.sites)
        return np.asarray(chosen.evaluate(shapes))


class StressLimit(PlacesLimit, tag="stress"):
    """Limit on stress: ``|stress| <= maximum`` at every instant.

    Examples
    --------
    >>> StressLimit("boom", 160e6).label
    'von-mises of boom'
    """

    maximum: Positive = field("Largest stress", unit="Pa")
    criterion: Criteria = field(
        'Such as "von-mises", "principal-1" or "s11", in the axes of the place',
        default="von-mises",
        kw_only=True,
    )

    @property
    def label(self) -> str:
        """Limited quantity, for messages."""
        return f"{self.criterion} of {self.body}"

    def ratios(self, rows: Array, y: Array) -> Array:
        """Return value / limit (ns, nt) at coordinates y (nc, nt)."""
        s = np.einsum("scn,nt->stc", rows, y)
        return np.abs(evaluate(s, self.criterion)) / self.maximum


class Place(Field["str | None", "str | None"]):
    """Type of fields: the name of a node, or None."""

    form = "text"
    noun = "str"


class DisplacementLimit(BodyLimit, tag="displacement"):
    """Limit on the elastic displacement of a node at every instant.

    ``|n . u| <= maximum`` along a direction n; without a direction ``|u| <= maximum``.
    For a body without supports the displacement is relative to a node, for example the foot of a
    boom.
    """

    maximum: Positive = field("Largest displacement", unit="m")
    node: Text = field("Name of the node")
    direction: Direction = field("Direction in part axes", default=None, kw_only=True)
    relative_to: Place = field(
        "Node in whose frame the displacement is measured", default=None, kw_only=True
    )

    @property
    def label(self) -> str:
        """Limited quantity, for messages."""
        return f"displacement of {self.body}.{self.node}"

    def places(self, body: Elastic) -> tuple[str, ...]:
        """Return the name of the node in a tuple."""
        return (self.node,)

    def rows(self, body: Elastic, shapes: Array) -> Array:
        """Return the displacement (1, 3 or 1, nc) of the node."""
        k = body.dofs_per_node
        width, first = min(k, 3), k * body.node(self.node)
        u = shapes[first : first + width]
        if self.relative_to is not None:
            u = u - carried(body, self.relative_to, shapes)[first : first + width]
        elif body.rigid.shape[1]:
            message = "the body has no support: name a node with relative_to="
            raise InputError(Problem(f"displacement limit of '{self.body}'", message))
        if self.direction is not None and width == 3:
            u = (self.direction / np.linalg.norm(self.direction))[None, :] @ u
        return u[None]

    def ratios(self, rows: Array, y: Array) -> Array:
        """Return value / limit (1, nt) at coordinates y (nc, nt)."""
        u = rows[0] @ y
        size = np.abs(u) if len(u) == 1 else np.linalg.norm(u, axis=0, keepdims=True)
        return np.asarray(size / self.maximum)


class Mean(AnyField):
    """Type of fields: a mean-stress correction, or None."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the correction, or report a value of another type."""
        if not isinstance(value, MeanStress):
            problems.add(where, f"{self.name} is {value!r}, must be a correction such as Goodman")
        return value


class LifeLimit(PlacesLimit, tag="life"):
    """Limit on life: the part endures a number of repeated runs.

    ``(D repeats)^(1/k) <= 1`` with the damage D of one run, rainflow-counted, and the slope k of
    the S-N curve: the root grows with the load as a stress does.
    """

    repeats: Positive = field("Number of runs that the part must survive", unit="1")
    sn: Item[SN] = field("Its S-N curve")
    mean: Mean = field(
        "Correction for mean stress", form="item", noun="MeanStress", default=None, kw_only=True
    )
    criterion: Criteria = field(
        "Signed criterion or component whose cycles are counted",
        default="signed-von-mises",
        kw_only=True,
    )

    @property
    def label(self) -> str:
        """Limited quantity, for messages."""
        return f"life of {self.body}"

    def ratios(self, rows: Array, y: Array) -> Array:
        """Return the root of damage (ns, 1) of the histories at coordinates y (nc, nt)."""
        s = evaluate(np.einsum("scn,nt->stc", rows, y), self.criterion)
        curve = reference(self.sn, self.mean)
        found = [_sum(rainflow(one, residue="repeat"), curve, self.mean) for one in s]
        D = np.maximum(np.asarray(found) * self.repeats, LEAST)
        return np.asarray(D[:, None] ** (1.0 / self.sn.k))


class FrequencyLimit(Limit, tag="frequency", by_value=True):
    """Lower limit on a natural frequency of the machine at its start."""

    minimum: Positive = field("Lowest frequency", unit="Hz")
    mode: Whole = field(
        "Number of the mode, from 1; motions without stiffness are not counted", least=1, default=1
    )

    @property
    def label(self) -> str:
        """Limited quantity, for messages."""
        return f"frequency {self.mode}"

    def ratio(self, frequencies: Array) -> float:
        """Return minimum / frequency from the natural frequencies, Hz."""
        if len(frequencies) < self.mode:
            message = f"there is no mode {self.mode}: the machine has {len(frequencies)}"
            raise InputError(Problem("frequency limit", message))
        found = float(frequencies[self.mode - 1])
        if not found > 0.0:
            message = (
                f"mode {self.mode} has {found:g} Hz: a motion without stiffness; limit another"
            )
            raise InputError(Problem("frequency limit", message))
        return float(self.minimum / found)


def stress_of(body: Elastic) -> Any:
    """Return the stress operator (6 ns, ndof) of a body.

    Raises
    ------
    InputError
        If the part of the body has no stress data.
    """
    if body.stress is None:
        raise InputError(Problem(f"body '{body.name}'", "its part has no stress data"))
    return body.stress


def carried(body: Elastic, node: str, shapes: Array) -> Array:
    """Return the rigid motion (ndof, nc) that follows one node of `shapes` (ndof, nc).

    Raises
    ------
    InputError
        If the node has no rotation.
    """
    if body.dofs_per_node != 6:
        message = f"node {node!r} does not turn: relative_to= names a node of beams"
        raise InputError(Problem(f"body '{body.name}'", message))
    rows = slice(6 * body.node(node), 6 * body.node(node) + 6)
    return np.asarray(body.rigid @ np.linalg.solve(body.rigid[rows], shapes[rows]))
