"""Bodies on a heavy hub that turns steadily, linearised by the engine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import jousto as jo


def on_a_hub(reduced: jo.ReducedPart, node: str, speed: float) -> NDArray[np.float64]:
    """Return the eigenvalues' imaginary parts, ascending, of a body fixed by a node to a hub.

    Parameters
    ----------
    reduced : ReducedPart
        Made into the body.
    node : str
        Name of the node that is fixed to the hub.
    speed : float
        About z, rad/s.
    """
    w = (0.0, 0.0, speed)
    hub = jo.RigidBody("hub", 1.0, (1e6, 1e6, 1e6), angular_velocity=w)
    blade = jo.FlexibleBody("blade", reduced, angular_velocity=w)
    model = jo.compile(
        jo.Mechanism(
            hub,
            blade,
            jo.Revolute("bearing", jo.ground["origin"], hub["origin"], axis=(0, 0, 1)),
            jo.Fixed("root", hub["origin"], blade[node]),
            jo.Gravity((0.0, 0.0, -1e-9)),
        )
    )
    return np.sort(np.linalg.eigvals(jo.simulation.linearise(model).A).imag)
