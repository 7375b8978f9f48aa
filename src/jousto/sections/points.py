"""Stress at points of a section from its six resultants, and the outline of a section."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.fields import Label, field
from jousto.base.numbers import Number, Values
from jousto.sections.profiles import Box, IBeam
from jousto.sections.section import ROUND, Circle, Rectangle, Section, Tube


class StressPoint(Declared):
    """Point of a beam section with its stress per unit resultant.

    ``[s11 s22 s33 s12 s23 s13] = rows [N Qy Qz Mx My Mz]``, with the resultants about the
    section's reference axis and in the axes of the section.

    Raises
    ------
    InputError
        If the rows are not 6 x 6 finite numbers, or the position is not finite.

    Examples
    --------
    >>> rows = np.zeros((6, 6))
    >>> rows[0] = [1.0 / 2e-4, 0, 0, 0, 0.005 / 6e-10, 0]
    >>> StressPoint("top", 0.0, 0.005, rows).name
    'top'
    """

    kind = "StressPoint"
    name: Label = field("Unique within the section")
    y: Number = field("Position along y, section axes", unit="m")
    z: Number = field("Position along z, section axes", unit="m")
    rows: Values = field(
        "Stress in Pa per N (first three columns) and per N m (last three), for example from a "
        "section analysis",
        shape=(6, 6),
    )


def stress_points(
    section: Section,
    centroid: tuple[float, float] = (0.0, 0.0),
    shear_center: tuple[float, float] | None = None,
) -> tuple[StressPoint, ...]:
    """Return the points of a section with their stress per unit resultant.

    ``s11 = N/A + My z/Iy - Mz y/Iz`` with the moments about the centroid, and the shear stresses
    of `SectionPoint` with the torque about the shear centre.

    Round sections have 24 points on the circumference: the four of the section and ``deg15``,
    ``deg30`` ... by their angle about x, from ``left`` (0) over ``top`` (90). The largest bending
    stress is at most 7.5 degrees from a point; the error is at most ``1 - cos(7.5 deg)`` = 0.9 %.

    Parameters
    ----------
    section : Section
        Section with its axes through the centroid.
    centroid : (2,) tuple
        Position of the centroid in the axes of the beam, m; the resultants refer to the axis of the
        beam.
    shear_center : (2,) tuple, optional
        Position of the shear centre, m; None for the centroid.

    Examples
    --------
    >>> top = stress_points(Rectangle(0.01, 0.02))[0]
    >>> f"{top.name} {top.rows[0, 0]:.0f} {top.rows[0, 4]:.0f}"
    'top 5000 1500000'
    """
    yc, zc = (float(x) for x in centroid)
    ys, zs = (yc, zc) if shear_center is None else (float(x) for x in shear_center)
    # resultants about the centroid and the shear centre: M - c x F
    shift = np.eye(6)
    shift[3, 1:3] = zs, -ys
    shift[4, 0], shift[5, 0] = -zc, yc
    found = []
    for point in section.points:
        rows = np.zeros((6, 6))
        rows[0, [0, 4, 5]] = 1.0 / section.A, point.z / section.Iy, -point.y / section.Iz
        rows[np.ix_((3, 5), (1, 2, 3))] = point.shear
        found.append(StressPoint(point.name, point.y + yc, point.z + zc, rows @ shift))
    return tuple(found)


def section_outline(section: Any, centroid: tuple[float, float] = (0.0, 0.0)) -> Array:
    """Return the outline of a section (k, 2), m, counterclockwise seen against x.

    For sections of unknown shape it is the rectangle with the same radii of gyration, or the points
    of a section given by its stiffness.

    Examples
    --------
    >>> section_outline(Rectangle(0.2, 0.1))[0]
    array([-0.1 , -0.05])
    """
    if isinstance(section, Circle):
        edge = _round(0.5 * section.diameter)
    elif isinstance(section, Tube):
        edge = _round(0.5 * section.outer_diameter)
    elif isinstance(section, IBeam):
        y, z, w = 0.5 * section.width, 0.5 * section.height, 0.5 * section.web
        t = z - section.flange
        right = [[y, -z], [y, -t], [w, -t], [w, t], [y, t], [y, z]]
        edge = np.array([*right, *([-a, -b] for a, b in right)])
    elif isinstance(section, Rectangle | Box):
        edge = _box(section.width, section.height)
    else:
        A = float(section.A)
        edge = _box(np.sqrt(12.0 * section.Iz / A), np.sqrt(12.0 * section.Iy / A))
    return np.asarray(edge + np.asarray(centroid, dtype=np.float64))


def _round(radius: float) -> Array:
    angle = 2.0 * np.pi * np.arange(ROUND) / ROUND
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _box(width: float, height: float) -> Array:
    return 0.5 * np.array([[-width, -height], [width, -height], [width, height], [-width, height]])
