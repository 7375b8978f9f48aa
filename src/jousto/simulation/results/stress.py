"""Stress modes, beams and frames in a results file: all data of stress recovery."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.model.beam_record import BeamShape, SectionShape
from jousto.model.frame_record import ARRAYS, FrameShape
from jousto.reduction.fields.stress import StressModes

GROUP = "stress"


BEAMS = "beams"
FRAME = "frame"


def stress_arrays(stress: StressModes) -> dict[str, Any]:
    """Return the datasets of stress modes by their path in the HDF5 group of a body."""
    ns = len(stress.labels)
    nodes = np.full(ns, -1, dtype=np.int64) if stress.nodes is None else stress.nodes
    arrays: dict[str, Any] = {
        "labels": np.array([label.encode() for label in stress.labels], dtype=np.bytes_),
        "positions": stress.positions,
        "axes": stress.axes,
        "modes": stress.modes,
        "nodes": nodes,
    }
    for name in ("elasticity", "compliance"):
        if getattr(stress, name) is not None:
            arrays[name] = getattr(stress, name)
    if stress.scatter is not None:
        arrays["scatter"] = stress.scatter.astype(np.float32)
    if stress.sets:
        # names of sets may contain any character, so they are data and not names of datasets
        members = list(stress.sets.values())
        arrays["set_names"] = np.array([key.encode() for key in stress.sets], dtype=np.bytes_)
        arrays["set_ends"] = np.cumsum([len(m) for m in members])
        arrays["set_members"] = np.concatenate(members)
    if stress.residual is not None:
        arrays["residual_names"] = np.array(
            [name.encode() for name in stress.residual.names], dtype=np.bytes_
        )
        arrays["residual"] = stress.residual.columns
        arrays["residual_static"] = stress.residual.static
    return {f"{GROUP}/{name}": array for name, array in arrays.items()}


def knows_stress(body: Any) -> bool:
    """Return whether a body (its HDF5 group) has stress modes."""
    return GROUP in body or "stress_nodes" in body


def read_stress(body: Any) -> StressModes | None:
    """Return the stress modes of a body (its HDF5 group), None if it has none."""
    if GROUP in body:
        group = body[GROUP]
        sets = {}
        if "set_names" in group:
            names = [name.decode() for name in group["set_names"][()]]
            pieces = np.split(group["set_members"][()], group["set_ends"][()][:-1])
            sets = dict(zip(names, pieces, strict=True))
        residual = None
        if "residual" in group:
            from jousto.reduction.fields.residual_stress import ResidualStress  # loads scipy

            residual = ResidualStress(
                tuple(name.decode() for name in group["residual_names"][()]),
                group["residual"][()],
                group["residual_static"][()],
            )
        return StressModes(
            tuple(label.decode() for label in group["labels"][()]),
            group["positions"][()],
            group["axes"][()],
            group["modes"][()],
            group["elasticity"][()] if "elasticity" in group else None,
            group["compliance"][()] if "compliance" in group else None,
            group["nodes"][()],
            sets,
            residual,
            group["scatter"][()] if "scatter" in group else None,
        )
    if (
        "stress_nodes" in body
    ):  # files of older versions: single precision at the nodes of a surface
        nodes = body["stress_nodes"][()]
        return StressModes(
            tuple(f"node{k + 1}" for k in nodes),
            body["nodes"][()][nodes],
            np.broadcast_to(np.eye(3), (len(nodes), 3, 3)),
            body["stress_modes"][()],
            nodes=nodes,
        )
    return None


def beam_arrays(beam: BeamShape) -> dict[str, Any]:
    """Return the datasets of a beam by their path in its HDF5 group."""
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
    """Return the beam in an HDF5 group."""
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


def frame_arrays(frame: FrameShape) -> dict[str, Any]:
    """Return the datasets of the elements of a frame by their path in the group of a body."""
    arrays: dict[str, Any] = {name: getattr(frame, name) for name in ARRAYS}
    arrays |= {f"edges/{k}": edge for k, edge in enumerate(frame.edges)}
    return {f"{FRAME}/{name}": array for name, array in arrays.items()}


def read_frame(body: Any) -> FrameShape | None:
    """Return the elements of the frame of a body (its HDF5 group), None if it has none."""
    if FRAME not in body:
        return None
    group = body[FRAME]
    arrays = {name: group[name][()] for name in ARRAYS}
    return FrameShape(
        **arrays, edges=tuple(group[f"edges/{k}"][()] for k in range(len(group["edges"])))
    )


def beam_knows_stress(group: Any) -> bool:
    """Return whether a beam (its HDF5 group) has points of a section."""
    return any(len(own["points"]) for own in group["sections"].values())
