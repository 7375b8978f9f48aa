"""Checks of CAD files before meshing: kind of file, completeness, unit."""

from __future__ import annotations

import re
from pathlib import Path

from jousto.base.errors import InputError, Problem
from jousto.base.units import LENGTHS
from jousto.mesh.formats import is_mesh
from jousto.mesh.readers.files import exists, unit_factor

_SI = {"": 1.0, "MILLI": 1e-3, "CENTI": 1e-2, "MICRO": 1e-6, "DECI": 1e-1, "KILO": 1e3}


def cad_scale(path: Path, unit: str | None) -> float:
    """Return the length in m of one unit of the imported geometry, after checks of the file.

    Gmsh converts STEP files to millimetres, and leaves the numbers of BREP files unchanged.
    """
    where = path.name
    if unit is not None:
        unit_factor(where, unit)
    exists(path)
    data = path.read_bytes()
    if data.lstrip()[:12] == b"ISO-10303-21":
        if b"END-ISO-10303-21" not in data[-4096:]:
            raise InputError(
                Problem(
                    where,
                    "has no END-ISO-10303-21 at its end: the file is truncated; export it again",
                )
            )
        own = step_unit(data)
        return 1e-3 if unit is None else 1e-3 * LENGTHS[unit] / own
    if re.match(rb"\s*(DBRep_DrawableShape|CASCADE Topology|Open CASCADE Topology)", data):
        if unit is None:
            raise InputError(
                Problem(where, "a BREP file contains no unit: give unit='mm' or another")
            )
        return LENGTHS[unit]
    if not data.strip():
        raise InputError(Problem(where, "is empty"))
    if re.match(rb".{72}S *0*1\s", data):
        raise InputError(
            Problem(
                where, "is an IGES file, which contains faces but no solid: export STEP instead"
            )
        )
    if is_mesh(path):
        raise InputError(
            Problem(where, "is a mesh, not a geometry: read it with jo.read_mesh(path)")
        )
    raise InputError(Problem(where, "is neither a STEP nor a BREP file"))


def step_unit(data: bytes) -> float:
    """Return the length unit of a STEP file in m; 0.001 (mm) if the file contains no unit.

    Examples
    --------
    >>> step_unit(b"#9=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));")
    0.001
    """
    text = re.sub(rb"\s+", b"", data)
    # inches and feet are defined as multiples of millimetres or metres
    found = re.search(
        rb"LENGTH_UNIT\(\)[^;]{0,400}?CONVERSION_BASED_UNIT\('(\w+)'|"
        rb"CONVERSION_BASED_UNIT\('(\w+)',#\d+\)LENGTH_UNIT",
        text,
    )
    if found:
        title = (found[1] or found[2]).decode().lower()
        known = {"inch": 0.0254, "foot": 0.3048, "millimetre": 1e-3, "metre": 1.0}
        if title in known:
            return known[title]
    found = re.search(rb"LENGTH_UNIT\(\)NAMED_UNIT\(\*\)SI_UNIT\((?:\.(\w+)\.|\$),\.METRE\.", text)
    if found:
        return _SI.get((found[1] or b"").decode(), 1e-3)
    return 1e-3
