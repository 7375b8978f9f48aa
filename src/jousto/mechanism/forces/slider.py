"""A point that slides along a track that bends."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.forces.base import Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.forces.track_path import OnTrack
from jousto.mechanism.signals.base import OptionalSignal

ROUNDING = 1e-9
"""Share of a piece of the track beyond its end that counts as rounding."""
SLIDER_STATES = {"piece": "1", "way": "m", "speed": "m/s"}
"""Piece of the track, from 0, way along it from its start, and speed, at the end of a step."""

EngineLaw(
    "slider",
    constants=(
        *("stiffness", "damping", "play", "hold", "brake"),
        *("mu", "resistance", "slow", "count"),
    ),
    states=SLIDER_STATES,
    between=True,
    fast={"springs": ()},
    yields=True,
).declared()


class Slider(OnTrack, tag="slider"):
    """A point that slides along a beam that bends: a trolley on its jib, a stage on its guide.

    The track is a smooth curve through markers, as of a `TrackContact`: nodes of modal bodies and
    exact beams, points of rigid bodies, in any order. Beyond a play around it the point b is held
    by a spring and a damper across the track, and it is free along it but for friction and drive:
    ``pull(t) + hold (reference(t) - s) + brake (reference'(t) - v) - (mu N + resistance)
    tanh(v / slow)``, with the way s along the undeformed track, the speed v and the force N across.
    A stiff slider is a moving mass with the terms ``w_tt + 2 v w_xt + v^2 w_xx``. Both sides
    receive the force at one point: momentum is kept exactly. Two sliders guide a body that must
    not turn.

    A `ForceStateSensor` measures "way", m, and "speed", m/s. Beyond the ends of the track the point
    is free.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> rail = (ground["origin"], ground.at((10, 0, 0)))
    >>> trolley = RigidBody("trolley", 300.0, (50, 50, 50), position=(1, 0, 0))
    >>> Slider("runner", rail, trolley["origin"], 1e7)
    <slider 'runner': 2 markers, trolley.origin>
    """

    kind = "slider"
    measured = ("force", "moment")
    together = ("track", "b", "stiffness", "mu", "hold", "brake", "reference")
    stiffness: Number = field("Stiffness across the track", unit="N/m", above=0)
    damping: Number = field("Damping across the track", unit="N s/m", least=0, default=0.0)
    play: Number = field("Play around the track", unit="m", least=0, default=0.0, kw_only=True)
    mu: Number = field("Coefficient of friction", unit="1", least=0, default=0.0, kw_only=True)
    resistance: Number = field(
        "Friction without normal force, as of seals or of rolling",
        unit="N",
        least=0,
        default=0.0,
        kw_only=True,
    )
    slow: Number = field(
        "Speed below which friction falls to 0", unit="m/s", above=0, default=1e-3, kw_only=True
    )
    pull: OptionalSignal = field(
        "Force along the track on b; None for none", unit="N", default=None, kw_only=True
    )
    reference: OptionalSignal = field(
        "Way along the track that a drive shall reach; None for no such drive",
        unit="m",
        default=None,
        kw_only=True,
    )
    hold: Number = field(
        "Force of the drive over the error of the way", unit="N/m", least=0, default=0.0,
        kw_only=True,
    )  # fmt: skip
    brake: Number = field(
        "Force of the drive over the error of the speed", unit="N s/m", least=0, default=0.0,
        kw_only=True,
    )  # fmt: skip

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a drive without gain, and a start beyond the ends or beside the track."""
        super().consistent(problems, where)
        gains = self.hold > 0 or self.brake > 0
        if (self.reference is None) == gains:
            problems.add(where, "reference goes with hold or brake; give both or none", "reference")
        if self.pieces and not self._on_track():
            problems.add(where, f"{self.b.label} is beyond the end of the track; move it", "b")

    def _on_track(self) -> bool:
        """Return whether the nearest place of the track is between its ends."""
        ends = [[np.real(marker.r) for marker in piece.ends] for piece in self.pieces]
        b = np.real(self.b.r)
        shares = [float((b - p) @ (q - p) / ((q - p) @ (q - p))) for p, q in ends]
        far = [
            float(np.linalg.norm(b - p - min(1.0, max(0.0, u)) * (q - p)))
            for u, (p, q) in zip(shares, ends, strict=True)
        ]
        k = int(np.argmin(far))
        before = k == 0 and shares[k] < -ROUNDING
        return not (before or (k == len(ends) - 1 and shares[k] > 1.0 + ROUNDING))

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The slider as a law of the engine."""
        names = ("stiffness", "damping", "play", "hold", "brake", "mu", "resistance", "slow")
        data = {name: getattr(self, name) for name in names} | {"count": len(self.pieces)}
        return (
            Push(
                "slider",
                data,
                b=self.b,
                states=tuple(SLIDER_STATES),
                numbers=self._rows,
                signal=self.pull,
                reference=self.reference,
            ),
        )
