"""Check of motors behind gears in a run: their turns can be counted up to half a turn in a step."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.model.gear_springs import gear_springs
from jousto.model.model import ForceModel, Model

HALF = np.pi
"""Largest change of a counted angle in a step in the positions of the bodies, rad."""


class MotorTurns:
    """Largest angle by which the motor of a gear spring turns in a step of fixed length."""

    def __init__(self, model: Model, gear: ForceModel, step: float) -> None:
        motor = model.coordinates[gear.other]
        bodies = [model.markers[side].body for side in (motor.a, motor.b)]
        self.step, self._gear = step, gear.name
        self._places = [
            (1 + model.bodies[i].iq + 3, 1 + model.nq + model.bodies[i].iv + 3) if i >= 0 else None
            for i in bodies
        ]

    def fastest(self, rows: NDArray[np.float64]) -> float:
        """Return the largest speed of the motor on its carrier in rows of the engine, rad/s."""
        carrier, rotor = (_spin(rows, place) for place in self._places)
        return float(np.linalg.norm(rotor - carrier, axis=1).max(initial=0.0))

    def sentence(self, speed: float) -> str:
        """Return the warning for a speed, rad/s; empty if the turns can be counted."""
        if not speed * self.step > HALF:
            return ""
        return (
            f"the motor of '{self._gear}' turns by up to {speed * self.step:.3g} rad in a step, "
            "but in the positions of the bodies turns are counted up to half a turn in a step: "
            f"the gear is wound wrongly; take steps below {HALF / speed:.2g} s, or joint "
            "coordinates, with ROS2 or an explicit method"
        )


def motor_turns(model: Model, step: float, *, joint_coordinates: bool) -> tuple[MotorTurns, ...]:
    """Return the checks of the motors that a method does not move in joint coordinates.

    Parameters
    ----------
    model : Model
    step : float
        Fixed step, s; 0 for a method that chooses it.
    joint_coordinates : bool
        Whether the method moves trees in joint coordinates.
    """
    geared = gear_springs(model) if step > 0.0 else ()
    if not geared:
        return ()
    links = model.links if joint_coordinates else ()
    moved = {coordinate for link in links for coordinate in link.coordinates}
    gears = [gear for gear in geared if gear.other not in moved]
    return tuple(MotorTurns(model, gear, step) for gear in gears)


def _spin(rows: NDArray[np.float64], place: tuple[int, int] | None) -> NDArray[np.float64]:
    """Return the angular velocity (k, 3) of a body in the world, rad/s; 0 of the ground (None)."""
    if place is None:
        return np.zeros((len(rows), 3))
    e, w = rows[:, place[0] : place[0] + 4], rows[:, place[1] : place[1] + 3]
    once = np.cross(e[:, 1:], w)
    return w + 2.0 * (e[:, :1] * once + np.cross(e[:, 1:], once))
