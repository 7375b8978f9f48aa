"""Mechanism: bodies, joints, forces and sensors, all checked together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import is_stepping
from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.rotations import rotation_matrix
from jousto.mechanism import checks
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.body import Body, FlexibleBody, RigidBody
from jousto.mechanism.checks import where as where
from jousto.mechanism.items_by_kind import CORES, STARTS, Members, word_problem
from jousto.mechanism.switched_checks import check_switched


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Mechanism(Members):
    """Bodies, joints, forces and sensors of one machine.

    Parameters
    ----------
    *items : body, joint, Gravity, force, Initial, Event, sensor, Fmu or robot
        Items in any order; bodies, joints, forces and sensors keep their order.
    name : str
        Name for plots and messages.
    core : str
        Solver core if none is given to `compile`: "joint" for joint coordinates, "maximal" for the
        positions of all bodies, "auto" for the faster one.
    start : str
        Initial state of runs to which none is given: the "initial" pose, "rest" (`equilibrium`) or
        "vibration-free", in which elastic bodies have their quasi-static deformation.

    Attributes
    ----------
    bodies, joints, couplings, forces, frictions, events, sensors : tuple
        The items by kind, in the given order; couplings has gears, racks, couplings and
        drives, forces all force elements. In bodies each beam is replaced by its nodes.
    beams : tuple of BeamBody
        The beams, in the given order.
    initials : tuple of Initial
        Values and rates of coordinates at the start.
    blocks : tuple of Block
        States with their equations.
    fmus : tuple of Fmu
        Models of other programs; their outputs are among the sensors.
    assemblies : tuple of Assembly
        Robots; their bodies, joints, forces and sensors are contained in the attributes above.
    gravity : (3,) array
        Acceleration of free fall, world frame, m/s2; zero without a `Gravity`.
    size : float
        Diagonal of the box around all bodies and joints at the initial pose, m.

    Raises
    ------
    InputError
        With all problems: unknown bodies, names used twice, gaps at joints and so on.

    Warns
    -----
    JoustoWarning
        If a body is not connected to anything, or a force acts on the ground.

    Examples
    --------
    >>> from jousto import Gravity, Revolute, RigidBody, ground
    >>> rod = RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    >>> pivot = Revolute("pivot", ground["origin"], rod["origin"])
    >>> Mechanism(rod, pivot, Gravity((0, -9.81, 0)), name="pendulum")
    <Mechanism 'pendulum': 1 body, 1 joint, 0 forces, 0 sensors>
    """

    def __init__(
        self, *items: Any, name: str = "mechanism", core: str = "auto", start: str = "initial"
    ) -> None:
        super().__init__(*items, name=name, core=core, start=start)
        if not is_stepping():  # complex steps reuse the check of the real values
            self.check()

    def __repr__(self) -> str:
        def count(kind: str, plural: str, items: Sequence[Any]) -> str:
            return f"{len(items)} {kind if len(items) == 1 else plural}"

        whole = [x for x in self.items if isinstance(x, RigidBody | FlexibleBody | BeamBody)]
        return (
            f"<Mechanism {self.name!r}: {count('body', 'bodies', whole)}, "
            f"{count('joint', 'joints', self.joints)}, {count('force', 'forces', self.forces)}, "
            f"{count('sensor', 'sensors', self.sensors)}>"
        )

    def pose(self, body: Body) -> tuple[Array, Array, Array]:
        """Return the initial pose of a body frame in the world.

        Returns
        -------
        R : (3,) array
            World position of the frame's origin, m.
        A : (3, 3) array
            Rotation matrix, local to world.
        e : (4,) array
            Euler parameters, scalar first.
        """
        return body.position, read_only(rotation_matrix(body.orientation)), body.orientation

    @property
    def mobility(self) -> int:
        """Degrees of freedom of rigid bodies minus the rows of joints, couplings and drives.

        A beam counts as one body, although each of its nodes moves freely.
        """
        rows = sum(joint.rows for joint in self.joints) + sum(
            not x.optional for x in self.couplings
        )
        nodes = sum(len(beam.bodies) for beam in self.beams)
        return 6 * (len(self.bodies) - nodes + len(self.beams)) - rows

    def check(self) -> None:
        """Raise InputError with all problems, and warn about likely mistakes."""
        problems = Problems()
        check_name(problems, "mechanism", self.name)
        for option, words in (("core", CORES), ("start", STARTS)):
            if problem := word_problem(option, getattr(self, option), words):
                problems.add(f"mechanism {self.name!r}", problem)
        checks.check_items(problems, self.items)
        checks.check_assemblies(problems, self)
        checks.check_starts(problems, self)
        checks.check_names(problems, self)
        checks.check_members(problems, self)
        checks.check_events(problems, self)
        checks.check_fmus(problems, self)
        checks.check_joints(problems, self)
        checks.check_rotations(problems, self)
        checks.check_drives(problems, self)
        checks.check_initials(problems, self)
        checks.check_distances(problems, self)
        checks.check_frictions(problems, self)
        check_switched(problems, self)
        problems.raise_if_any()
        checks.warn_unconnected(self)
        checks.warn_interfaces(self)
        checks.warn_jumps(self)
        checks.warn_ground_loads(self)
