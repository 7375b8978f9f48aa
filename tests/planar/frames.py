"""Planar frames for the tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.planar.frame import PlanarFrame
from jousto.planar.items import (
    FunctionLink,
    LinearLink,
    PlanarBeam,
    PlanarDamping,
    PlanarLoad,
    PlanarMass,
    PlanarSupport,
    RigidLink,
)
from jousto.planar.section import PlanarSection

Array = NDArray[Any]
ROD = PlanarSection(EA=3e4, GA=1e4, EI=50.0, mass=2.0, rotary=0.05)


def chain(elements: int, length: float = 1.0, section: PlanarSection = ROD, **more: Any) -> Any:
    """A straight beam along x, clamped at node 0."""
    nodes = [(length * i / elements, 0.0) for i in range(elements + 1)]
    beams = [PlanarBeam(i, i + 1, section) for i in range(elements)]
    given: dict[str, Any] = {"supports": [PlanarSupport(0, rotation=True)]}
    return PlanarFrame(nodes, beams, **{**given, **more})


def slide(u: Array) -> Array:
    """A slider on the line from p to q, which turns with that line; 1 m apart along x."""
    dx, dy = 1.0 + u[3] - u[0], u[4] - u[1]
    angle = np.arctan(dy / dx)
    share = 0.4 + u[6]
    # the slider began at 0.4 m
    return np.array([u[0] + share * dx - 0.4, u[1] + share * dy, angle])


def everything(**more: Any) -> PlanarFrame:
    """Offsets, three kinds of links, masses, dead and following loads, all damping."""
    nodes = {
        "p": (0.0, 0.0),
        "q": (1.0, 0.0),
        "slider": (0.4, 0.0),
        "far": (0.6, 1.1),
        "hub": (1.3, 0.4),
        "rim": (1.6, 0.3),
        "pin": (1.2, 0.9),
        "tip": (2.4, 0.5),
        "twin": (2.4, 1.0),
    }
    beams = [
        PlanarBeam("p", "q", ROD, offset_a=(0.1, 0.2), offset_b=(-0.1, 0.15)),
        PlanarBeam("q", "hub", ROD),
        PlanarBeam("slider", "far", ROD, offset_a=(0.05, 0.1)),
        PlanarBeam("rim", "tip", ROD),
        PlanarBeam("far", "pin", ROD, offset_b=(0.0, -0.1)),
        PlanarBeam("pin", "twin", ROD),
    ]
    half = np.zeros((3, 6))
    half[:, :3], half[:, 3:] = 0.7 * np.eye(3), 0.3 * np.eye(3)
    return PlanarFrame(
        nodes,
        beams,
        supports=[PlanarSupport("p", rotation=True)],
        loads=[
            PlanarLoad("tip", force=(30.0, -20.0), moment=4.0, signal=np.cos),
            PlanarLoad("rim", force=(40.0, 25.0), follow=True),
            PlanarLoad("slider", force=(-5.0, 25.0), follow=True),
        ],
        links=[
            FunctionLink(("slider",), ("p", "q"), slide, coordinates=("share",)),
            RigidLink("hub", ("rim",)),
            RigidLink("hub", ("pin",), rotation=False),
            LinearLink(("twin",), ("tip", "far"), half, (0.01, 0.0, 0.02)),
        ],
        masses=[PlanarMass("far", 3.0, 0.2)],
        damping=PlanarDamping(mass=0.3, stiffness=2e-3),
        gravity=(0.5, -9.81),
        **more,
    )
