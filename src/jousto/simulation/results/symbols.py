"""Symbols of a mechanism in a results file, for pictures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from jousto.base.rotations import euler_parameters_of, rotation_matrix
from jousto.model.symbol_record import CylinderShape, SymbolPoint, SymbolShape

GROUP = "symbols"
SCALAR_LAST, SCALAR_FIRST = [1, 2, 3, 0], [3, 0, 1, 2]  # files have e1 e2 e3 e0
WORDS = ("name", "kind", "group", "text", "sensor")


def symbol_arrays(found: Sequence[SymbolShape]) -> dict[str, Any]:
    """Return the datasets of symbols; points and modes of all symbols are concatenated."""
    points = [point for one in found for point in one.points]
    modes = [np.zeros((0, 3)) if x.modes is None else x.modes.T for x in points]
    words = [[getattr(one, word) for one in found] for word in WORDS]
    none = np.full(3, np.nan)
    axes = np.array([point.axes for point in points]).reshape(-1, 3, 3)
    turns = euler_parameters_of(axes)[:, SCALAR_LAST]
    return {
        "words": np.frombuffer(json.dumps(words, ensure_ascii=False).encode(), dtype=np.uint8),
        "ends": np.cumsum([len(one.points) for one in found], dtype="<i8"),
        "axes": np.array([none if one.axis is None else one.axis for one in found]),
        "fixed": np.array([one.fixed for one in found], dtype=np.uint8),
        "bodies": np.array([point.body for point in points], dtype="<i8"),
        "nodes": np.array([point.node for point in points], dtype="<i8"),
        "points": np.array([point.u0 for point in points]).reshape(-1, 3),
        "turns": turns,
        "modes": np.concatenate([*modes, np.zeros((0, 3))]),
        "mode_ends": np.cumsum([len(some) for some in modes], dtype="<i8"),
        **_triangles(found),
        **_cylinders(found),
    }


def _cylinders(found: Sequence[SymbolShape]) -> dict[str, Any]:
    """Return the sizes of hydraulic cylinders, by the numbers of their symbols, as JSON."""
    some = {k: one.cylinder._asdict() for k, one in enumerate(found) if one.cylinder is not None}
    if not some:
        return {}
    return {"cylinders": np.frombuffer(json.dumps(some, ensure_ascii=False).encode(), "u1")}


def _triangles(found: Sequence[SymbolShape]) -> dict[str, Any]:
    """Return the triangles of shapes and where those of each symbol end; nothing without shapes."""
    some = [np.zeros((0, 3, 3)) if x.triangles is None else x.triangles for x in found]
    if not any(map(len, some)):
        return {}
    ends = np.cumsum([len(x) for x in some], dtype="<i8")
    return {"triangles": np.concatenate(some), "triangle_ends": ends}


def check_symbols(found: tuple[SymbolShape, ...], bodies: Any) -> tuple[SymbolShape, ...]:
    """Return the symbols unchanged if all their points refer to existing bodies and nodes.

    Raises
    ------
    ValueError
        With the first symbol that refers to a missing body, node or mode.
    """
    known = [(len(body["nodes"]), int(body.attrs["modes"])) for body in bodies.values()]
    for one in found:
        for point in one.points:
            if not -1 <= point.body < len(known):
                raise ValueError(
                    f"symbol '{one.name}' is on body {point.body}, there are {len(known)} bodies"
                )
            nodes, modes = known[point.body] if point.body >= 0 else (0, 0)
            if not -1 <= point.node < max(nodes, 1):
                raise ValueError(
                    f"symbol '{one.name}' is at node {point.node}, its body has {nodes} nodes"
                )
            if point.modes is not None and point.modes.shape != (3, modes):
                raise ValueError(f"symbol '{one.name}' does not have the {modes} modes of its body")
    return found


def read_symbols(group: Any) -> tuple[SymbolShape, ...]:
    """Return the symbols in an HDF5 group."""
    arrays = {name: group[name][()] for name in group}
    axes = rotation_matrix(arrays["turns"][:, SCALAR_FIRST])
    cuts = np.concatenate([[0], arrays["mode_ends"]])
    points = []
    for k, (body, node, u0) in enumerate(
        zip(arrays["bodies"], arrays["nodes"], arrays["points"], strict=True)
    ):
        modes = arrays["modes"][cuts[k] : cuts[k + 1]]
        points.append(
            SymbolPoint(int(body), u0, axes[k], int(node), modes.T if len(modes) else None)
        )
    words = json.loads(arrays["words"].tobytes().decode())
    ends = np.concatenate([[0], arrays["ends"]])
    if (np.diff(ends) < 0).any() or ends[-1] != len(points):
        raise ValueError(f"{GROUP}/ends does not divide {len(points)} points among the symbols")
    cut, surface = np.zeros(len(ends), dtype=np.int64), np.zeros((0, 3, 3))
    if "triangles" in arrays:
        cut = np.concatenate([[0], arrays["triangle_ends"]])
        surface = arrays["triangles"].astype(np.float64)
        if len(cut) != len(ends) or (np.diff(cut) < 0).any() or cut[-1] != len(surface):
            raise ValueError(f"{GROUP}/triangle_ends does not divide {len(surface)} triangles")
    cylinders: dict[str, Any] = {}
    if "cylinders" in arrays:
        cylinders = json.loads(arrays["cylinders"].tobytes().decode())
    found = []
    for k, texts in enumerate(zip(*words, strict=True)):
        axis = arrays["axes"][k]
        own = surface[cut[k] : cut[k + 1]]
        found.append(
            SymbolShape(
                **dict(zip(WORDS, texts, strict=True)),
                points=tuple(points[ends[k] : ends[k + 1]]),
                axis=None if np.isnan(axis).any() else axis,
                fixed=bool(arrays["fixed"][k]),
                triangles=own if len(own) else None,
                cylinder=_cylinder(cylinders.get(str(k))),
            )
        )
    return tuple(found)


def _cylinder(read: dict[str, Any] | None) -> CylinderShape | None:
    """Return the sizes of a cylinder from those in a file."""
    if read is None:
        return None
    bore, rod, closed, stroke = (float(read[key]) for key in ("bore", "rod", "closed", "stroke"))
    names = read["pressures"]
    return CylinderShape(bore, rod, closed, stroke, (str(names[0]), str(names[1])))
