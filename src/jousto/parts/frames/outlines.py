"""Outlines of the sections of a frame, for drawing its members."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.object_repr import described
from jousto.sections.points import section_outline
from jousto.sections.section import Section


@described
@dataclass(frozen=True, eq=False)
class Outlines:
    """Outlines of the different sections of a frame, and the index of the outline of each element.

    Attributes
    ----------
    edges : tuple of (k, 2) arrays
        Points y, z in section axes, m, counterclockwise seen against x.
    which : (ne,) int array
        Index of the outline of each element.
    """

    edges: tuple[Array, ...]
    which: Ints


def outlines_of(sections: Sequence[Section]) -> Outlines:
    """Return the outlines of the sections of all elements."""
    kinds = {id(section): section for section in sections}
    place = {key: k for k, key in enumerate(kinds)}
    return Outlines(
        tuple(np.array(section_outline(section).real) for section in kinds.values()),
        np.array([place[id(section)] for section in sections], dtype=np.int64),
    )
