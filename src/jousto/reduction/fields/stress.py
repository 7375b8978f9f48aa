"""Modal stress: stress of every mode at stress sites."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described

if TYPE_CHECKING:
    from jousto.reduction.fields.residual_stress import ResidualStress


@described
@dataclass(frozen=True, eq=False)
class StressModes:
    """Stress of each mode at ns sites; the stress of a moving body is ``modes @ p``.

    Parameters
    ----------
    labels : tuple of str
        Names of the sites, such as ``e3.a.top``.
    positions : (ns, 3) array
        Positions of the sites, part frame, m.
    axes : (ns, 3, 3) array
        Columns are the axes in which the stress is resolved, part frame.
    modes : (ns, 6, n) array
        ``[s11, s22, s33, s12, s23, s13]`` of each mode, Pa per unit modal coordinate.
    elasticity : (ns, 2) array, optional
        Young's modulus, Pa, and Poisson's ratio at each site; None if unknown.
    compliance : (ns, 6, 6) array, optional
        Strain ``[e11 e22 e33 g12 g23 g13]`` from stress at each site, 1/Pa, in the axes of the
        site: for anisotropic materials.
    nodes : (ns,) int array, optional
        Node of the body at each site, -1 for none. Several sites may belong to one node, such as
        the points of a beam section, or one site per material at a node.
    sets : mapping of str to (k,) int array
        Named groups of sites, by index; each group contains the sites at the nodes of a node set.
    residual : ResidualStress, optional
        Stress outside of the modes.
    scatter : (ns, r, n) array, optional
        For parts of solids: ``|scatter p|`` is the estimated discretisation error of the stress,
        Pa, as in `place_errors`. None if unknown.

    Raises
    ------
    InputError
        If lengths are inconsistent, names occur twice, or values are not finite.
    """

    labels: tuple[str, ...]
    positions: Array
    axes: Array
    modes: Array
    elasticity: Array | None = None
    compliance: Array | None = None
    nodes: NDArray[np.int64] | None = None
    sets: Mapping[str, NDArray[np.int64]] = field(default_factory=dict)
    residual: ResidualStress | None = None
    scatter: Array | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        labels = tuple(self.labels)
        ns = len(labels)
        n = int(np.shape(self.modes)[-1]) if np.ndim(self.modes) == 3 else 0
        positions = problems.array("StressModes", "positions", self.positions, (ns, 3))
        axes = problems.array("StressModes", "axes", self.axes, (ns, 3, 3))
        modes = problems.array("StressModes", "modes", self.modes, (ns, 6, n))
        if len(set(labels)) != ns:
            twice = next(label for label in labels if labels.count(label) > 1)
            problems.add("StressModes", f"label '{twice}' is used more than once")
        elasticity = self.elasticity
        if elasticity is not None:
            elasticity = problems.array("StressModes", "elasticity", elasticity, (ns, 2))
        compliance = self.compliance
        if compliance is not None:
            compliance = problems.array("StressModes", "compliance", compliance, (ns, 6, 6))
        nodes = self.nodes
        if nodes is not None:
            nodes = np.array(nodes, dtype=np.int64)
            if nodes.shape != (ns,):
                problems.add("StressModes", f"nodes has shape {nodes.shape}, must be ({ns},)")
        scatter = self.scatter
        if scatter is not None:
            scatter = problems.array("StressModes", "scatter", scatter, (ns, None, None))
        sets = {str(k): np.array(v, dtype=np.int64) for k, v in self.sets.items()}
        for key, members in sets.items():
            if members.size and not 0 <= members.min() <= members.max() < ns:
                problems.add("StressModes", f"set '{key}' refers to sites outside 0..{ns - 1}")
        problems.raise_if_any()
        object.__setattr__(self, "labels", labels)
        object.__setattr__(self, "compliance", compliance)
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "scatter", scatter)
        object.__setattr__(self, "sets", Frozen(sets))
        object.__setattr__(self, "elasticity", elasticity)
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "axes", axes)
        object.__setattr__(self, "modes", modes)

    def nearest(self, point: ArrayLike) -> str:
        """Return the label of the site nearest to a point in the part frame, m."""
        away = np.linalg.norm(self.positions - np.asarray(point, dtype=np.float64), axis=1)
        return self.labels[int(np.argmin(away))]

    def keep(self, indices: NDArray[np.intp]) -> StressModes:
        """Return the stress of selected modes, in the given order."""
        residual = self.residual and self.residual.keep(np.asarray(indices), self.modes)
        scatter = None if self.scatter is None else self.scatter[:, :, indices]
        return replace(self, modes=self.modes[:, :, indices], residual=residual, scatter=scatter)

    def combined(self, V: Array) -> StressModes:
        """Return the stress of linear combinations ``V`` (n, m) of the modes."""
        scatter = None if self.scatter is None else self.scatter @ V
        return replace(self, modes=self.modes @ V, scatter=scatter)

    def mesh_error(self, place: int, p: Array) -> float:
        """Return the estimated discretisation error of the stress at a site, Pa; nan if unknown."""
        if self.scatter is None:
            return float("nan")
        rows = self.scatter[place]
        return float(np.linalg.norm(rows @ p[: rows.shape[1]]))

    def select(self, places: NDArray[np.intp]) -> StressModes:
        """Return selected sites, by index, in the given order."""
        if np.array_equal(places, np.arange(len(self.labels))):
            return self
        where = np.full(len(self.labels), -1, dtype=np.int64)
        where[places] = np.arange(len(places))
        found = {key: where[members] for key, members in self.sets.items()}
        found = {key: members[members >= 0] for key, members in found.items()}
        return StressModes(
            tuple(self.labels[i] for i in places),
            self.positions[places],
            self.axes[places],
            self.modes[places],
            None if self.elasticity is None else self.elasticity[places],
            None if self.compliance is None else self.compliance[places],
            None if self.nodes is None else self.nodes[places],
            {key: members for key, members in found.items() if len(members)},
            self.residual and replace(self.residual, columns=self.residual.columns[places]),
            None if self.scatter is None else self.scatter[places],
        )
