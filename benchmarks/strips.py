"""A strip of plastic of geometrically exact beam elements that hangs on a spherical joint."""

from __future__ import annotations

from typing import Any

import jousto as jo

LENGTH, WIDTH, E, NU, RHO = 1.0, 0.01, 2e9, 0.3, 7850.0  # m, m, Pa, 1, kg/m3
LEANING, UPRIGHT = (0.0, -8.5, -4.9), (0.0, -9.81, 0.0)  # m/s2


def mechanism(elements: int, gravity: tuple[float, float, float], fine: bool = False) -> Any:
    """The strip on its hinge."""
    strip = jo.BeamBody(
        "strip",
        [[0, 0, 0], [LENGTH, 0, 0]],
        jo.Rectangle(WIDTH, WIDTH),
        jo.Material(E=E, nu=NU, rho=RHO),
        elements=elements,
        bending=fine,
        mass="corrected" if fine else "lumped",
    )
    return jo.Mechanism(
        strip,
        jo.Spherical("hinge", jo.ground["origin"], strip["start"]),
        jo.Gravity(gravity),
        jo.PositionSensor("tip", strip["end"]),
    )
