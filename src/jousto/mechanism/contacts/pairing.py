"""Pairs of shapes that touch at several points."""

from __future__ import annotations

from jousto.base.errors import Problems
from jousto.mechanism.contacts.polytopes import Polytope, too_fine
from jousto.mechanism.contacts.shapes import Shape

POINTS = 8
"""Most points at which two shapes touch (``JO_CORNERS``, ``JO_MESH_POINTS``)."""
POINTS_OF_SPHERE = 4
"""Most points at which a sphere touches a surface of triangles."""


def paired(on: Shape, of: Shape) -> bool:
    """Return whether `of` touches `on` in points: convex shapes, half-spaces, surfaces.

    A round shape touches neither surfaces of triangles nor, in this way, half-spaces.
    """
    if of.hollow:
        return False
    if of.mesh is not None:  # by its hull
        return on.hollow and on.polytope is not None
    if of.polytope is None or on.mesh is not None:
        return of.polytope is not None and not of.polytope.round
    return on.polytope is not None and (not on.hollow or not of.polytope.round)


def most_points(on: Shape, of: Shape) -> int:
    """Return the largest number of points at which two shapes touch, for which `paired` is true."""
    assert of.polytope is not None
    own = _points_of(of.polytope)
    if on.mesh is not None:
        return min(POINTS, POINTS_OF_SPHERE * own)
    assert on.polytope is not None
    return min(own, _points_of(on.polytope))


def _points_of(shape: Polytope) -> int:
    """Return the largest number of points of a shape; an ellipsoid touches at one."""
    return POINTS if shape.faces else max(1, len(shape.vertices))


def check_pair(problems: Problems, where: str, on: Shape, of: Shape) -> None:
    """Report what is wrong with a pair for which `paired` is true."""
    if of.mesh is not None:
        try:
            assert of.polytope is not None
            fault = too_fine(of.polytope)
        except ValueError as error:
            fault = f"the hull of the {of.tag} {error}"
        if fault:
            problems.add(where, f"{fault}; take a coarser surface, or let it be the one touched")
    elif on.mesh is not None and not on.mesh.closed:
        assert of.polytope is not None
        if not on.mesh.radius + of.polytope.radius > 0.0:
            problems.add(
                where,
                f"corners of a {of.tag} pass an open {on.tag} without thickness; give it a "
                "thickness, or close it",
            )
