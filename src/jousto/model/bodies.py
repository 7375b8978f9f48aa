"""What flexible bodies cannot do: asked when a mechanism is compiled."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.inertia import principal_inertia
from jousto.mechanism.mechanism import Mechanism

LINE = 1e-5  # ratio of principal moments of inertia below which mass lies nearly on a line
TURN = 0.1  # rad that a rotation linear in the modes may reach: its square is then 1 %
SMALL = 1e-3  # of the length of the body: a bending that must not turn the frame by that much
ALIKE = 0.1  # of the mean turn: what differs from it along the body


def warn_bodies(mechanism: Mechanism) -> None:
    """Warn of mean axes that turn by far more than the body bends, once for each part."""
    seen: set[int] = set()
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody) and id(body.reduced) not in seen:
            seen.add(id(body.reduced))
            _warn_line(body)


def _warn_line(body: FlexibleBody) -> None:
    reduced = body.reduced
    moments, axes = principal_inertia(reduced.invariants)
    if moments[0] >= LINE * moments[-1] or reduced.rotations is None:
        return
    length = float(np.ptp(reduced.nodes @ axes[:, 0]))
    turns = np.einsum("kaj,a->kj", reduced.rotations, axes[:, 0])
    mean = turns.mean(axis=0)
    moves = np.abs(reduced.modes).max(axis=(0, 1))
    bends = np.abs(turns - mean).max(axis=0) < ALIKE * np.abs(mean)
    reach = TURN * moves[bends] / np.abs(mean[bends])
    if not len(reach) or reach.min() >= SMALL * length:
        return
    mode = int(np.flatnonzero(bends)[int(np.argmin(reach))])
    warn(
        f"body '{body.name}'",
        f"nearly all its mass lies on one line, about which it has {moments[0] / moments[-1]:.1e} "
        f"of its other inertia: bending of only {reach.min():.2g} m in mode {mode + 1} turns the "
        f"axes of its motion by {TURN} rad about that line, which modes cannot follow: deflections "
        "in one plane come out too small; give the section its rotary inertia "
        "(rotary_inertia=True), see it from the node that holds it "
        "(jo.reduction.clamp(reduced, 'node1')), add point masses beside the line, or keep the "
        "modes of one plane only "
        "(reduced.keep(reduced.in_plane('xy')))",
    )
