"""More models for both codes: rigid chains, a slider-crank and a four-bar with flexible links.

All start at rest and move under `GRAVITY`. The loops have no repeated rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import jousto as jo
from cases import GRAVITY, LENGTH, beam

SECTION = jo.Rectangle(0.03, 0.04)
SOFT = jo.Material(E=2.07e9, nu=0.3, rho=7850.0)  # as the flexible chains
MASS = 7850.0 * 0.03 * 0.04 * LENGTH  # kg of one rigid link
INERTIA = MASS / 12.0 * np.array([0.03**2 + 0.04**2, LENGTH**2 + 0.03**2, LENGTH**2 + 0.04**2])
CENTER = (LENGTH / 2.0, 0.0, 0.0)

CRANK, RAIL, PIVOT = 0.3, 0.2, (1.2, 0.0, 0.1)  # m: slider-crank's crank and rail, four-bar's base
ANGLE = 0.6  # rad, of both cranks at the start
ROCKER = 0.9  # m


@dataclass(frozen=True)
class RigidChain:
    """`bodies` equal rigid links in a row, each hinged to the one before."""

    joint: str
    bodies: int
    t_end: float

    @property
    def name(self) -> str:
        return f"rigid chain of {self.bodies}, {self.joint}"

    def axis(self, k: int) -> tuple[float, float, float]:
        """Axis of the revolute joint before link k: z, y, z, ..."""
        return (0.0, 0.0, 1.0) if k % 2 == 0 else (0.0, 1.0, 0.0)


RIGID_CHAINS = tuple(
    RigidChain(joint, bodies, t_end)
    for joint in ("spherical", "revolute")
    for bodies, t_end in ((10, 0.5), (100, 0.1), (1000, 0.02))
)


def rigid_chain(case: RigidChain) -> jo.Mechanism:
    """The rigid chain in jousto."""
    items: list[object] = []
    before = jo.ground["origin"]
    for k in range(case.bodies):
        link = jo.RigidBody(
            f"link{k + 1}",
            MASS,
            INERTIA,
            center=CENTER,
            markers={"start": (0, 0, 0), "end": (LENGTH, 0, 0)},
            position=(k * LENGTH, 0.0, 0.0),
        )
        if case.joint == "spherical":
            items += [link, jo.Spherical(f"joint{k + 1}", before, link["start"])]
        else:
            items += [link, jo.Revolute(f"joint{k + 1}", before, link["start"], case.axis(k))]
        before = link["end"]
    return jo.Mechanism(*items, jo.Gravity(GRAVITY), jo.PositionSensor("tip", before))


def along(direction: Sequence[float]) -> np.ndarray:
    """Return a rotation matrix with the direction as its first column."""
    x = np.asarray(direction) / np.linalg.norm(direction)
    y = np.cross([0.0, 0.0, 1.0], x)
    y /= np.linalg.norm(y)
    return np.column_stack([x, y, np.cross(x, y)])


@dataclass(frozen=True)
class Link:
    """A link from `start` to `end` (world, m) with its modes, or rigid."""

    name: str
    start: np.ndarray
    end: np.ndarray
    reduced: jo.ReducedPart | None = None

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.end - self.start))

    @property
    def turn(self) -> np.ndarray:
        return along(self.end - self.start)

    @property
    def mass(self) -> float:
        return MASS * self.length / LENGTH

    @property
    def inertia(self) -> np.ndarray:
        square = self.length**2 / 12.0
        return self.mass * np.array([2.1e-4, square, square])


def clamped(length: float) -> jo.ReducedPart:
    """A beam with four modes, the lowest when it is clamped at the start."""
    part = jo.Part.beam(length=length, section=SECTION, elements=8, material=SOFT, lumped=True)
    return jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=4))


def slider_crank_links() -> tuple[Link, Link]:
    """Rigid crank and flexible rod, ten modes; the rail runs along x at z = RAIL."""
    pin = CRANK * np.array([np.cos(ANGLE), np.sin(ANGLE), 0.0])
    reach = np.sqrt(LENGTH**2 - pin[1] ** 2 - RAIL**2)
    slider = np.array([pin[0] + reach, 0.0, RAIL])
    return Link("crank", np.zeros(3), pin), Link("rod", pin, slider, beam(10))


def four_bar_links() -> tuple[Link, Link, Link]:
    """Three flexible links: crank and rocker with four modes, coupler with ten."""
    base = np.array(PIVOT)
    pin = 0.6 * np.array([np.cos(ANGLE), np.sin(ANGLE), 0.0])
    # the rocker turns about z: its end at base + ROCKER (cos b, sin b, 0), LENGTH from the pin
    b = np.linspace(0.3, 2.8, 100_001)
    ends = base + ROCKER * np.column_stack([np.cos(b), np.sin(b), np.zeros_like(b)])
    gap = np.linalg.norm(ends - pin, axis=1) - LENGTH
    k = int(np.flatnonzero(np.diff(np.sign(gap)))[0])
    angle = b[k] - gap[k] * (b[k + 1] - b[k]) / (gap[k + 1] - gap[k])
    end = base + ROCKER * np.array([np.cos(angle), np.sin(angle), 0.0])
    return (
        Link("crank", np.zeros(3), pin, clamped(0.6)),
        Link("coupler", pin, end, beam(10)),
        Link("rocker", base, end, clamped(ROCKER)),
    )


def body(link: Link) -> jo.RigidBody | jo.FlexibleBody:
    """The link in jousto."""
    if link.reduced is not None:
        return jo.FlexibleBody(link.name, link.reduced, position=link.start, orientation=link.turn)
    return jo.RigidBody(
        link.name,
        link.mass,
        link.inertia,
        center=(link.length / 2.0, 0.0, 0.0),
        markers={"start": (0, 0, 0), "end": (link.length, 0, 0)},
        position=link.start,
        orientation=link.turn,
    )


def slider_crank() -> jo.Mechanism:
    """Spatial slider-crank: revolute, spherical, spherical, prismatic joint."""
    crank, rod = (body(link) for link in slider_crank_links())
    start = slider_crank_links()[1].end
    slider = jo.RigidBody("slider", 2.0, (0.01, 0.01, 0.01), position=start)
    return jo.Mechanism(
        crank,
        rod,
        slider,
        jo.Revolute("bearing", jo.ground["origin"], crank["start"], (0, 0, 1)),
        jo.Spherical("crank pin", crank["end"], rod["start"]),
        jo.Spherical("slider pin", rod["end"], slider["origin"]),
        jo.Prismatic("rail", jo.ground.at(start), slider["origin"], (1, 0, 0)),
        jo.Gravity(GRAVITY),
        jo.PositionSensor("tip", rod["end"]),
    )


def four_bar() -> jo.Mechanism:
    """Spatial four-bar: two revolute joints on ground, two spherical ones at the coupler."""
    crank, coupler, rocker = (body(link) for link in four_bar_links())
    return jo.Mechanism(
        crank,
        coupler,
        rocker,
        jo.Revolute("left", jo.ground["origin"], crank["start"], (0, 0, 1)),
        jo.Spherical("crank pin", crank["end"], coupler["start"]),
        jo.Spherical("rocker pin", coupler["end"], rocker["end"]),
        jo.Revolute("right", jo.ground.at(PIVOT), rocker["start"], (0, 0, 1)),
        jo.Gravity(GRAVITY),
        jo.PositionSensor("tip", coupler["end"]),
    )
