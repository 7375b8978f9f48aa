"""Rosenbrock W-methods: linearly implicit, without iteration."""

from __future__ import annotations

from typing import ClassVar

from jousto.simulation.solvers.base import Staged


class Rosenbrock(Staged):
    """Base of linearly implicit methods for modes, exact beams and forces along coordinates.

    The methods are A-stable, so that no mode of a body limits the step.
    """


class ROS2(Rosenbrock, tag="ROS2"):
    """Linearly implicit W-method of order 2 with the modal stiffness and damping implicit.

    ROS2 of Verwer, Spee, Blom and Hundsdorfer (SIAM J. Sci. Comput. 20, 1999) with
    gamma = 1 - 1/sqrt 2. A step takes two evaluations. The only iteration is the projection,
    usually one correction and at most four, so that the work of a step is bounded. High modal
    frequencies do not limit the step; modes that the step cannot resolve are damped.
    """

    method: ClassVar[str] = "ros2"


class ROS3A(Rosenbrock, tag="ROS3A"):
    """Linearly implicit W-method of order 3, stiffly accurate and L-stable.

    A step takes four evaluations and no iteration. The stages are those of the method of Alexander
    (SIAM J. Numer. Anal. 14, 1977) with gamma = 0.43587; all rows of the implicit coefficients
    except the first have the sum 0. Therefore the method keeps its order for any approximation of
    the Jacobian (W-method), and also with a mass matrix that is updated in each stage. The latter
    requires ``sum b_i c_i g_i = 0`` in addition to the conditions of order 3; ROS34PW2 of Rang and
    Angermann (BIT 45, 2005) does not satisfy it. Explicit terms have the stability region of `RK4`.
    """

    method: ClassVar[str] = "ros3a"
