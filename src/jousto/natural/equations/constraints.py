"""Constraint rows: joints, couplings, drives, and the orthonormality of body axes."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.mechanism import Mechanism
from jousto.natural.equations.coordinates import Scalars
from jousto.natural.equations.frames import Frames

PAIRS = ((1, 1), (2, 2), (3, 3), (1, 2), (1, 3), (2, 3))

Terms = list[tuple[float, tuple[str, int]]]


class Rows:
    """Constraints ``C = F s - offset - signal(t) = 0``, linear in scalar functions s.

    Attributes
    ----------
    of : dict
        Rows of every joint, coupling and drive, by its id.
    names : list of str
        Name of the joint, coupling or drive of each row.
    F : array (m, ns)
        Factors of the scalar functions.
    offset : array (m,)
        Constants.
    signals : list
        Pairs of row index and signal.
    together : list of int arrays (k, n)
        Rows of the k joints with n rows, for every n.
    """

    def __init__(self, mechanism: Mechanism, frames: Frames, scalars: Scalars) -> None:
        self._rows: list[tuple[Terms, float]] = []
        self.of: dict[int, slice] = {}
        self.names: list[str] = []
        self.signals: list[tuple[int, Any]] = []
        held: tuple[Joint | Coupler, ...] = (*mechanism.joints, *mechanism.couplings)
        for joint in held:
            first = len(self._rows)
            if isinstance(joint, Joint):
                self._joint(joint, frames, scalars)
            for line in joint.lines:
                terms = [
                    (float(f), scalars.coordinate(s))
                    for f, s in zip(line.factors, line.coordinates, strict=True)
                ]
                if line.signal is not None:
                    self.signals.append((len(self._rows), line.signal))
                self._rows.append((terms, line.offset))
            self.of[id(joint)] = slice(first, len(self._rows))
            self.names += [joint.name] * (len(self._rows) - first)
        self.joints = len(self._rows)
        own = [np.arange(rows.start, rows.stop) for rows in self.of.values()]
        self.together = [
            np.stack([rows for rows in own if len(rows) == n])
            for n in sorted({len(rows) for rows in own})
        ]
        for body in mechanism.bodies:
            frame = frames.place(Marker(body, "frame", np.zeros(3), None, np.eye(3)))
            for i, j in PAIRS:
                self._rows.append(
                    ([(1.0, scalars.add("product", frame, frame, (i, j)))], 1.0 * (i == j))
                )
            self.names += [body.name] * len(PAIRS)

    def _joint(self, joint: Joint, frames: Frames, scalars: Scalars) -> None:
        a, b = (frames.place(marker) for marker in joint.frames)
        if joint.coincident:
            self._rows += [([(1.0, scalars.add("gap", a, b, k))], 0.0) for k in range(3)]
        self._rows += [
            ([(1.0, scalars.add("product", a, b, (1 + i, 1 + j)))], 0.0)
            for i, j in joint.perpendicular
        ]

    def close(self, scalars: Scalars) -> None:
        """Build the arrays after all scalar functions were added."""
        self.F = np.zeros((len(self._rows), scalars.count))
        for row, (terms, _) in enumerate(self._rows):
            for factor, place in terms:
                self.F[row, scalars.number(place)] += factor
        self.offset = np.array([offset for _, offset in self._rows])
        self._time, self._jets = np.nan, np.zeros((3, len(self._rows)))

    def scales(self, scalars: Scalars, length: float) -> Array:
        """Return the scale (m,) of each constraint: `length` for lengths, 1 for others."""
        each = np.where(scalars.long, length, 1.0)
        return np.asarray((np.abs(self.F) * each).max(axis=1, initial=0.0))

    def driven(self, t: float, order: int) -> Array:
        """Return the signals of all rows (m,) at a time, or their derivative of an order."""
        if t != self._time:  # cached, since a step uses one time repeatedly
            jets = np.zeros((3, len(self.offset)))
            for row, signal in self.signals:
                jets[:, row] = signal.jet(np.array(t))
            self._jets, self._time = jets, t
        return np.asarray(self._jets[order])
