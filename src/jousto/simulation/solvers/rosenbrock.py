"""Rosenbrock W-methods: linearly implicit, without iteration."""

from __future__ import annotations

from typing import ClassVar

from jousto.simulation.solvers.base import Staged


class Rosenbrock(Staged):
    """Modes, exact beams and what acts along joint coordinates are implicit, without iteration.

    The methods are A-stable, so that no mode of a body limits the step.
    """


class ROS2(Rosenbrock, tag="ROS2"):
    """Linearly implicit W-method of order 2 with the modal stiffness and damping implicit.

    ROS2 of Verwer, Spee, Blom and Hundsdorfer (SIAM J. Sci. Comput. 20, 1999) with
    gamma = 1 - 1/sqrt 2. Two evaluations a step and no iteration but the projection, which is one
    correction, rarely more and never more than four: the work of a step is bounded. High modal
    frequencies do not limit the step; modes that the step cannot resolve are damped.
    """

    method: ClassVar[str] = "ros2"


class ROS3A(Rosenbrock, tag="ROS3A"):
    """Linearly implicit W-method of order 3, stiffly accurate and L-stable.

    Four evaluations a step, without iteration. The stages are those of the method of Alexander
    (SIAM J. Numer. Anal. 14, 1977) with gamma = 0.43587; all rows of the implicit coefficients but
    the first sum up to 0. So the method keeps its order whatever the matrix leaves out
    (W-method), and also though its masses are those of each stage: that takes
    ``sum b_i c_i g_i = 0`` besides the conditions of order 3, which ROS34PW2 of Rang and Angermann
    (BIT 45, 2005) does not meet. What is explicit is stable as in `RK4`.
    """

    method: ClassVar[str] = "ros3a"
