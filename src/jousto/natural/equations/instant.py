"""State of a machine for the evaluation of forces, and the sums of their effects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.arrays import Array, crossed
from jousto.natural.equations.frames import Pose


@dataclass(eq=False)
class Instant:
    """State of a machine for the evaluation of forces.

    Attributes
    ----------
    t : float
        Time, s.
    q, v : arrays
        Coordinates and velocities.
    pose : Pose
        Markers.
    s, rate : arrays (ns,)
        Scalar functions and their rates.
    gradients : array (ns, 2, 4, 3)
        Derivatives of scalar functions with respect to both markers.
    lam : array (m,)
        Multipliers.
    """

    t: float
    q: Array
    v: Array
    pose: Pose
    s: Array
    rate: Array
    gradients: Array
    lam: Array

    @property
    def y(self) -> Array:
        """Points and axes of all markers."""
        return self.pose.y

    @cached_property
    def dy(self) -> Array:
        """Rates of the points and axes of all markers."""
        return self.pose.rates(self.v)


@dataclass(eq=False)
class Action:
    """Sums of the effects of all forces.

    Attributes
    ----------
    along : array (ns,)
        Forces along scalar functions.
    loads : array (nm, 4, 3)
        Forces on the points and axes of markers.
    direct : array (nb, 12 + n)
        Forces on the coordinates of bodies.
    stored, damping, rubbed, work : float
        Energy in springs, J, and the powers of dampers, of friction, and of external forces, W.
    felt : list
        Sensor value of every law.
    slopes : list
        Numbers of scalar functions, or bodies (k, 2) and derivatives (k, 2, 12 + n) of others,
        with stiffness and damping (k, k) along them.
    """

    along: Array
    loads: Array
    direct: Array
    stored: float = 0.0
    damping: float = 0.0
    rubbed: float = 0.0
    work: float = 0.0
    felt: list[Array] = field(default_factory=list)
    slopes: list[tuple[Any, Array, Array]] = field(default_factory=list)


Law = Callable[[Instant, Action], None]


def moment(y: Array, T: Array) -> Array:
    """Return the forces (4, 3) of a torque T on the axes of a marker: ``T x axis / 2``."""
    out = np.zeros((4, 3))
    out[1:] = 0.5 * crossed(T, y[1:])
    return out
