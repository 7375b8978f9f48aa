"""Wheel or ball on a track: a smooth curve through markers, such as nodes of a beam."""

from __future__ import annotations

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import DefaultNumber, Number
from jousto.mechanism.contacts.effective_mass import mobility
from jousto.mechanism.contacts.friction import default_static
from jousto.mechanism.contacts.laws import NUMBERS, TABLE, ContactLawField, Hertz
from jousto.mechanism.forces.base import Push
from jousto.mechanism.forces.contact import LAW_NUMBERS, SHEAR, STATES, duration
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.forces.track_path import OnTrack

TRACK_STATES = STATES | {"piece": "1"}
"""States of a contact, and the piece of the track on which the wheel is, from 0."""

EngineLaw(
    "contact track",
    units={"mu_static": "1", "mu_kinetic": "1"},
    constants=("radius", "count", *LAW_NUMBERS),
    states=TRACK_STATES,
    between=True,
    fast={"contacts": ()},
    yields=True,
).declared()


class TrackContact(OnTrack, tag="track-contact"):
    """Wheel or ball on a track that bends: a bridge under a train, a ball on a beam.

    The track is a smooth curve through markers: from each to the next one a cubic with the tangents
    of both frames, as the bending line of a beam. The wheel is where ``(r_b - r(x)) . r'(x) = 0``;
    there the depth of the overlap ``radius - (r_b - r(x)) . n`` gives the force by the law, with
    restitution, lift-off and friction as of a `Contact`. The wheel may run from rail to beam to
    rail; beyond the ends there is no track. Both sides receive the force at one point: momentum is
    kept exactly.

    Between successive markers on one flexible body the track passes all nodes on the line. On an
    exact beam name every node, or use `nodes_along`. Across the track the wheel is not guided: hold
    it there by a joint.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> from jousto.mechanism import SpringDamper, TrackContact
    >>> rail = (ground["origin"], ground.at((10, 0, 0)))
    >>> wheel = RigidBody("wheel", 1000.0, (50, 50, 50), position=(1, 0, 0.5))
    >>> TrackContact("wheel", rail, wheel["origin"], SpringDamper(1e7), radius=0.5)
    <track-contact 'wheel': 2 markers, wheel.origin>
    """

    kind = "contact on a track"
    measured = ("force", "moment")
    together = ("track", "b", "law", "mu_kinetic", "mu_static")
    law: ContactLawField = field("Law of the normal force")
    radius: Number = field(
        "Radius of the wheel; 0 for a point", unit="m", least=0, default=0.0, kw_only=True
    )
    mu_kinetic: Number = field(
        "Coefficient of friction while it slips; 0 for no friction",
        unit="1",
        least=0,
        default=0.0,
        kw_only=True,
    )
    mu_static: DefaultNumber = field(
        "Coefficient of friction up to which it sticks; None: mu_kinetic",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    shear: Number = field(
        "Stiffness of the bristle over that of the normal force, 2 (1 - nu) / (2 - nu)",
        unit="1",
        above=0,
        default=SHEAR,
        kw_only=True,
    )

    def __post_init__(self) -> None:
        default_static(self)
        super().__post_init__()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a law without radius, friction that does not fit, and wrong tracks."""
        if self.law.curve == TABLE:
            problems.add(where, "a track has no TableLaw; give a PowerLaw", "law")
        if isinstance(self.law, Hertz) and not self.radius:
            problems.add(where, "Hertz's law needs a radius", "radius")
        if self.mu_static < self.mu_kinetic:
            problems.add(
                where, f"mu_static {self.mu_static:g} is below mu_kinetic {self.mu_kinetic:g}"
            )
        super().consistent(problems, where)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The contact as a law of the engine."""
        law = NUMBERS | self.law.numbers(1.0 / self.radius if self.radius else None)
        track = max(mobility(marker, 0.0) for marker in self._markers)
        mass = 1.0 / (mobility(self.b, self.radius) + track)
        data = law | {
            "mu_static": self.mu_static,
            "mu_kinetic": self.mu_kinetic,
            "shear": self.shear if self.mu_static else 0.0,
            "velocity": 0.0,
            "mass": mass,
            "duration": duration(mass, law["stiffness"], law["exponent"]),
            "resolve": 0.0,
            "restitution": 0.0,
            "radius": self.radius,
            "count": len(self.pieces),
        }
        states = tuple(TRACK_STATES)
        return (Push("contact track", data, b=self.b, states=states, numbers=self._rows),)
