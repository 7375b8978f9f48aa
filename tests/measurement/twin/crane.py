"""The folding crane of the examples, once as the truth and once as its twin knows it."""

from __future__ import annotations

from typing import Any

import numpy as np

import jousto as jo

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
BOOM, JIB = jo.Box(0.16, 0.22, web=0.006, flange=0.006), jo.Box(0.12, 0.18, web=0.005, flange=0.005)
ALONG = [[0.96, 0, 0.28], [0, 1, 0], [-0.28, 0, 0.96]]
RISE = [[0.8, 0, -0.6], [0, 1, 0], [0.6, 0, 0.8]]
DRIVES = {
    "slewing": ((1.0, 6.0), (0.0, np.radians(30.0))),
    "luffing": ((4.5, 6.0), (2.25, 2.45)),
    "folding": ((1.0, 4.0), (0.0, np.radians(20.0))),
}


def boom(fine: bool) -> jo.ReducedPart:
    """The boom of 8 elements and 3 fixed-interface modes; as the truth 16 elements and 10 modes."""
    part = jo.Part.beam(4.0, BOOM, 16 if fine else 8, STEEL, name="boom")
    eye = "node7" if fine else "node4"
    return jo.reduce(part, jo.CraigBampton(("start", eye, "end"), modes=10 if fine else 3))


def crane(
    reduced: jo.ReducedPart,
    *,
    fine: bool,
    payload: float = 0.0,
    beta: float = 2e-3,
    gust: Any = None,
) -> jo.Mechanism:
    """The crane; with a payload, kg, that feels gusts, N."""
    part = jo.Part.beam(3.0, JIB, 12 if fine else 6, STEEL, name="jib")
    arm = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6 if fine else 3))
    soft = jo.Rayleigh(0.0, beta)
    column = jo.RigidBody(
        "column",
        900.0,
        (250.0, 250.0, 40.0),
        center=(0, 0, 0.9),
        markers={"head": (0, 0, 1.8), "foot": (0.57, 0, 0.54)},
    )
    lower = jo.FlexibleBody("boom", reduced, damping=soft, position=(0, 0, 1.8), orientation=RISE)
    upper = jo.FlexibleBody("jib", arm, damping=soft, position=(3.2, 0, 4.2))
    barrel = jo.RigidBody(
        "barrel", 60.0, (8, 8, 0.1), center=(0, 0, 0.6), position=(0.57, 0, 0.54), orientation=ALONG
    )
    piston = jo.RigidBody(
        "piston", 40.0, (5, 5, 0.05), center=(0, 0, -0.6), position=(1.2, 0, 2.7), orientation=ALONG
    )
    slew = jo.Revolute("slew ring", jo.ground["origin"], column["origin"], axis=(0, 0, 1))
    knuckle = jo.Revolute("knuckle", lower["end"], upper["start"], axis=(0, 1, 0))
    cylinder = jo.Prismatic("cylinder", barrel["origin"], piston["origin"], axis=(0.28, 0, 0.96))
    items: list[Any] = [
        column,
        lower,
        upper,
        barrel,
        piston,
        slew,
        jo.Revolute("hinge", column["head"], lower["start"], axis=(0, 1, 0)),
        knuckle,
        jo.Universal(
            "foot", column["foot"], barrel["origin"], axis_a=(0, 1, 0), axis_b=(0.96, 0, -0.28)
        ),
        cylinder,
        jo.Spherical("eye", piston["origin"], lower["node7" if fine else "node4"]),
        jo.Drive("slewing", slew.angle, jo.SCurve(*DRIVES["slewing"])),
        jo.Drive("luffing", cylinder.displacement, jo.SCurve(*DRIVES["luffing"])),
        jo.Drive("folding", knuckle.angle, jo.SCurve(*DRIVES["folding"])),
        jo.Gravity((0, 0, -9.81)),
    ]
    if payload:
        load = jo.RigidBody(
            "load",
            payload,
            (0.16 * payload,) * 3,
            position=(6.2, 0, 2.2),
            markers={"rope": (0, 0, 2.0)},
        )
        items += [
            load,
            jo.Universal("hook", upper["end"], load["rope"], axis_a=(1, 0, 0), axis_b=(0, 1, 0)),
        ]
        if gust is not None:
            items += [
                jo.Force(f"gust {i}", load["center"], axis, signal=s)
                for i, (axis, s) in enumerate(gust)
            ]
    return jo.Mechanism(*items, name="crane")
