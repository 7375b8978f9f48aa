"""The models that both codes run: beams in a row, hanging from ground, falling under gravity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import jousto as jo

# gravity has a z component so that the motion is spatial; the section is not square for the same
# reason (bending in y and z has different frequencies)
GRAVITY = (0.0, -8.5, -4.9)
LENGTH = 1.0
ELEMENTS = 16
# softer than steel, so that a step of 1 ms resolves the highest mode: 194 Hz of ten modes with
# 2.07e9 Pa, 245 Hz of thirty modes with 2.07e8 Pa
YOUNG = {10: 2.07e9, 30: 2.07e8, 100: 2.07e8}


@dataclass(frozen=True)
class Case:
    """`bodies` equal beams of `modes` modal coordinates, each hinged to the one before."""

    joint: str
    bodies: int
    modes: int
    t_end: float = 1.0

    @property
    def name(self) -> str:
        if self.bodies == 1:
            return f"pendulum, {self.joint}, n = {self.modes}"
        return f"chain of {self.bodies}, {self.joint}, n = {self.modes}"

    @property
    def times(self) -> np.ndarray:
        """Times in s at which the tips are compared."""
        return np.linspace(0.0, self.t_end, 21)[1:]

    def axis(self, k: int) -> tuple[float, float, float]:
        """Axis of the revolute joint before body k: z, y, z, ... no two neighbours agree."""
        return (0.0, 0.0, 1.0) if k % 2 == 0 else (0.0, 1.0, 0.0)


PENDULUMS = tuple(Case("spherical", 1, n) for n in (2, 10, 30))
CHAINS = tuple(
    Case(joint, bodies, 10, t_end={1: 1.0, 5: 1.0, 20: 0.5, 100: 0.2}[bodies])
    for joint in ("spherical", "revolute")
    for bodies in (1, 5, 20, 100)
    if (joint, bodies) != ("spherical", 1)  # that one is among the pendulums
)


def beam(modes: int, young: float | None = None) -> jo.ReducedPart:
    """One beam with its lowest `modes` modes, lumped mass with rotary inertia; `young`: Pa."""
    if young is None:
        young = max(e for n, e in YOUNG.items() if n >= modes)
    part = jo.Part.beam(
        length=LENGTH,
        section=jo.Rectangle(0.03, 0.04),
        elements=max(ELEMENTS, modes // 4),
        material=jo.Material(E=young, nu=0.3, rho=7850.0),
        lumped=True,
    )
    return jo.reduce(part, jo.FreeFree(modes=modes))


def mechanism(case: Case, reduced: jo.ReducedPart) -> jo.Mechanism:
    """The case in jousto."""
    items: list[object] = []
    before = jo.ground["origin"]
    for k in range(case.bodies):
        body = jo.FlexibleBody(f"beam{k + 1}", reduced, position=(k * LENGTH, 0.0, 0.0))
        if case.joint == "spherical":
            items += [body, jo.Spherical(f"joint{k + 1}", before, body["start"])]
        else:
            items += [body, jo.Revolute(f"joint{k + 1}", before, body["start"], case.axis(k))]
        before = body["end"]
    return jo.Mechanism(*items, jo.Gravity(GRAVITY), jo.PositionSensor("tip", before))
