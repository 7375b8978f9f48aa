"""Deflection of a flexible body as an outcome of a study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.complexstep import norm, scalar
from jousto.base.errors import suggest
from jousto.base.object_repr import described
from jousto.design.studies.case import Case
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.mechanism.bodies.body import FlexibleBody


@described
@dataclass(frozen=True, eq=False)
class Deflection(Outcome):
    """Largest elastic displacement of a node over the run, in the frame of another node, m.

    The value is ``|u - (u_0 + theta_0 x (r - r_0))|`` with the displacement u_0 and the rotation
    theta_0 of the other node.
    """

    name: str
    body: str
    node: str
    seen_from: str

    def value(self, case: Case) -> float:
        """Return the deflection at one point."""
        reduced = self._body(case).reduced
        q = case.run.coordinates(self.body)[:, 7:].T
        (tip,), (foot,) = reduced.node_sets[self.node], reduced.node_sets[self.seen_from]
        u, u_0, theta_0 = (
            at @ q for at in (reduced.modes[tip], reduced.modes[foot], reduced.rotations[foot])
        )
        arm = reduced.nodes[tip] - reduced.nodes[foot]
        d = u - u_0 - np.cross(theta_0, arm[:, None], axis=0)
        return scalar(norm(d, axis=0).max())

    def _body(self, case: Case) -> Any:
        return next(body for body in case.mechanism.bodies if body.name == self.body)

    def unit(self, case: Case) -> str:
        """Return the unit m."""
        return "m"

    def check(self, case: Case) -> str:
        """Return the problem of an unknown body or node, empty if there is none."""
        known = [body.name for body in case.mechanism.bodies if isinstance(body, FlexibleBody)]
        if self.body not in known:
            return f"no flexible body {self.body!r}{suggest(self.body, known)}"
        reduced = self._body(case).reduced
        nodes = [name for name, members in reduced.node_sets.items() if len(members) == 1]
        for name in (self.node, self.seen_from):
            if name not in nodes:
                return f"body {self.body!r} has no node {name!r}{suggest(name, nodes)}"
        if reduced.rotations is None:
            return f"node {self.seen_from!r} does not turn: it must be a node of beams"
        return ""
