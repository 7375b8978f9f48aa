"""Beams in a results file, so that their forces and stress follow from the file alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.model.beam_record import BeamShape, SectionShape

GROUP = "beams"


def beam_arrays(beam: BeamShape) -> dict[str, Any]:
    """Return the datasets of a beam by their place in its group."""
    names = ("bodies", "data", "s", "nodes", "frames", "which")
    arrays: dict[str, Any] = {name: getattr(beam, name) for name in names}
    for k, section in enumerate(beam.sections):
        own = {
            "labels": np.array([label.encode() for label in section.labels] or [b""]),
            "points": section.points,
            "rows": section.rows,
            "outline": section.outline,
        }
        if section.elasticity is not None:
            own["elasticity"] = section.elasticity
        arrays |= {f"sections/{k}/{name}": array for name, array in own.items()}
    return arrays


def read_beam(name: str, group: Any) -> BeamShape:
    """Return a beam of its HDF5 group."""
    found = []
    for k in range(len(group["sections"])):
        own = group[f"sections/{k}"]
        found.append(
            SectionShape(
                tuple(x.decode() for x in own["labels"][: len(own["points"])]),
                own["points"][()],
                own["rows"][()],
                own["outline"][()],
                own["elasticity"][()] if "elasticity" in own else None,
            )
        )
    return BeamShape(
        name,
        group["bodies"][()],
        group["data"][()],
        group["s"][()],
        group["nodes"][()],
        group["frames"][()],
        tuple(found),
        group["which"][()],
    )


def beam_knows_stress(group: Any) -> bool:
    """Return whether a beam (its HDF5 group) has points of a section."""
    return any(len(own["points"]) for own in group["sections"].values())
