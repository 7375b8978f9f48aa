"""Warning about bodies moved at the start to fit the drives."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.errors import warn
from jousto.mechanism.checks import GAP_TOLERANCE, drives_of, where
from jousto.mechanism.mechanism import Mechanism
from jousto.model.model import Model


def warn_moved(mechanism: Mechanism, model: Model, placed: Array) -> None:
    """Warn about drives whose initial value differs from their coordinate, and moved bodies.

    Differences up to the tolerance for gaps at joints cause no warning: 1e-6 of the size of the
    mechanism, or rad.

    Parameters
    ----------
    mechanism : Mechanism
    model : Model
        Model at its initial state.
    placed : (nq,) array
        Declared positions [R e p] of the bodies.
    """
    found = []
    for drive in drives_of(mechanism):
        begins, stands, gap = drive.beginning
        unit = drive.coordinate.unit
        if abs(gap) > GAP_TOLERANCE * (mechanism.size if unit == "m" else 1.0):
            found.append(
                f"{where(drive)} begins at {begins:.6g} {unit}, but {drive.coordinate.name} stands "
                f"at {stands:.6g} {unit}"
            )
    if found:
        warn(
            f"mechanism {mechanism.name!r}",
            f"{some(found, 4)}; the start fits the drives, which moved {_moved(model, placed)}; "
            f"let signals begin at the values of the coordinates, or place the bodies at the "
            f"beginning of the signals",
        )


def _moved(model: Model, placed: Array) -> str:
    """Return the moved bodies and their displacements, the largest first."""
    ways = []
    for body in model.bodies:
        old, new = (np.asarray(q)[body.iq : body.iq + 7] for q in (placed, model.q0))
        away = float(np.linalg.norm(new[:3] - old[:3]))
        (s, x), (t, y) = (old[3], old[4:]), (new[3], new[4:])
        vector = (
            s * y - t * x - np.cross(x, y)
        )  # vector part of the quaternion from the old to the new orientation
        turned = 2.0 * float(np.arctan2(np.linalg.norm(vector), abs(s * t + x @ y)))
        far, wide = away > GAP_TOLERANCE * model.size, turned > GAP_TOLERANCE
        how = [f"by {away:.4g} m"] * far + [f"by {np.degrees(turned):.4g} degrees"] * wide
        if how:
            # equal rotations (to rounding) are sorted by displacement
            most = float(f"{max(away / model.size, turned):.9g}")
            ways.append((most, away, f"'{body.name}' {' and '.join(how)}"))
    ways.sort(key=lambda way: (-way[0], -way[1]))
    return some([text for _, _, text in ways], 4) or "modes alone"
