"""Beams in a results file, so that their forces and stress follow from the file alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.engine import BeamShape

GROUP = "beams"


def beam_arrays(beam: BeamShape) -> dict[str, Any]:
    """Return the datasets of a beam by their place in its group."""
    arrays: dict[str, Any] = {
        "bodies": beam.bodies,
        "data": beam.data,
        "s": beam.s,
        "labels": np.array([label.encode() for label in beam.labels], dtype="S"),
        "points": beam.points,
        "rows": beam.rows,
        "outline": beam.outline,
    }
    if not beam.labels:
        arrays["labels"] = np.zeros(0, dtype="S1")
    if beam.elasticity is not None:
        arrays["elasticity"] = beam.elasticity
    return arrays


def read_beam(name: str, group: Any) -> BeamShape:
    """Return a beam of its HDF5 group."""
    return BeamShape(
        name,
        group["bodies"][()],
        group["data"][()],
        group["s"][()],
        tuple(label.decode() for label in group["labels"][()]),
        group["points"][()],
        group["rows"][()],
        group["outline"][()],
        group["elasticity"][()] if "elasticity" in group else None,
    )
