"""Sensors: what the engine records while it steps.

Every sensor says its unit, the frame it is resolved in and the names of its components.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias

from jousto.errors import InputError, Problem, Problems, suggest
from jousto.mechanism.body import FlexibleBody
from jousto.mechanism.fields import check_name, set_fields
from jousto.mechanism.gauges import CoordinateSensor, EnergySensor, RateSensor, SignalSensor
from jousto.mechanism.joints import JOINTS, Joint
from jousto.mechanism.marker import Marker, as_marker

XYZ = ("x", "y", "z")


@dataclass(frozen=True, eq=False, init=False)
class PositionSensor:
    """World position of a marker, (3,) m."""

    unit: ClassVar[str] = "m"
    resolved_in: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = XYZ
    name: str
    marker: Marker

    def __init__(self, name: str, marker: Marker) -> None:
        init_marker_sensor(self, name, marker)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"position of {self.marker.label}"


@dataclass(frozen=True, eq=False, init=False)
class VelocitySensor:
    """World velocity of a marker, (3,) m/s."""

    unit: ClassVar[str] = "m/s"
    resolved_in: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = XYZ
    name: str
    marker: Marker

    def __init__(self, name: str, marker: Marker) -> None:
        init_marker_sensor(self, name, marker)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"velocity of {self.marker.label}"


@dataclass(frozen=True, eq=False, init=False)
class OrientationSensor:
    """Euler parameters (4,) of a marker's axes in the world, scalar first."""

    unit: ClassVar[str] = "1"
    resolved_in: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("e0", "e1", "e2", "e3")
    name: str
    marker: Marker

    def __init__(self, name: str, marker: Marker) -> None:
        init_marker_sensor(self, name, marker)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"orientation of {self.marker.label} (Euler parameters, scalar first)"


@dataclass(frozen=True, eq=False, init=False)
class AngularVelocitySensor:
    """Angular velocity (3,) of a marker, rad/s, world frame."""

    unit: ClassVar[str] = "rad/s"
    resolved_in: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = XYZ
    name: str
    marker: Marker

    def __init__(self, name: str, marker: Marker) -> None:
        init_marker_sensor(self, name, marker)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"angular velocity of {self.marker.label}"


@dataclass(frozen=True, eq=False, init=False)
class ModalSensor:
    """Modal coordinates and velocities of a flexible body, (2n,): p then p'."""

    unit: ClassVar[str] = "kg^0.5 m, kg^0.5 m/s"
    resolved_in: ClassVar[str] = "body"
    name: str
    body: FlexibleBody

    def __init__(self, name: str, body: FlexibleBody) -> None:
        init_body_sensor(self, name, body)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, p1..pn then p1'..pn'."""
        n = self.body.n
        p = tuple(f"p{j + 1}" for j in range(n))
        return p + tuple(f"{name}'" for name in p)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"modal coordinates and velocities of {self.body.name}"


@dataclass(frozen=True, eq=False, init=False)
class ReactionSensor:
    """Force and moment (6,) of a joint on the body of marker b, at the joint, world frame."""

    unit: ClassVar[str] = "N, N m"
    resolved_in: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
    name: str
    joint: Joint

    def __init__(self, name: str, joint: Joint) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        checked: Any = joint
        if not isinstance(checked, JOINTS):
            problems.add(where, f"joint is {checked!r}, must be a joint")
        problems.raise_if_any()
        set_fields(self, name=name, joint=joint)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"reaction of {self.joint.name} on {self.joint.b.body.name}"


@dataclass(frozen=True, eq=False, init=False)
class StressSensor:
    """Stress at section points of a flexible body, (6 ns,) Pa.

    Six components [s11, s22, s33, s12, s23, s13] of each site after each other, in the
    element's axes.

    Parameters
    ----------
    name : str
        Name, unique among the sensors.
    body : FlexibleBody
        A body whose part knows stresses.
    sites : sequence of str, optional
        Labels of the stress sites, such as ``"e3.a.top"``; None for all of them.
    """

    unit: ClassVar[str] = "Pa"
    resolved_in: ClassVar[str] = "element"
    name: str
    body: FlexibleBody
    sites: tuple[str, ...]

    def __init__(
        self, name: str, body: FlexibleBody, sites: Iterable[str] | str | None = None
    ) -> None:
        init_body_sensor(self, name, body)
        labels = stress_labels(body)
        where = f"sensor {name!r}"
        if labels is None:
            raise InputError(
                Problem(where, f"body {body.name!r} has no stress modes; its part knows no stress")
            )
        wanted = labels if sites is None else (sites,) if isinstance(sites, str) else tuple(sites)
        problems = Problems()
        if not wanted:
            problems.add(where, "sites is empty; None takes all of them")
        for site in wanted:
            if site not in labels:
                problems.add(
                    where,
                    f"sites: body {body.name!r} has no stress site {site!r}"
                    f"{suggest(str(site), labels)}",
                )
        problems.raise_if_any()
        set_fields(self, sites=wanted)

    @property
    def indices(self) -> tuple[int, ...]:
        """Rows of the sites in ``body.reduced.stress``."""
        labels = stress_labels(self.body) or ()
        position = {label: i for i, label in enumerate(labels)}
        return tuple(position[site] for site in self.sites)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components, ``site:s11`` and so on."""
        voigt = ("s11", "s22", "s33", "s12", "s23", "s13")
        return tuple(f"{site}:{s}" for site in self.sites for s in voigt)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"stress of {self.body.name}"


MarkerSensor: TypeAlias = (
    PositionSensor | VelocitySensor | OrientationSensor | AngularVelocitySensor
)
BodySensor: TypeAlias = ModalSensor | StressSensor
Gauge: TypeAlias = CoordinateSensor | RateSensor | EnergySensor | SignalSensor
Sensor: TypeAlias = MarkerSensor | BodySensor | ReactionSensor | Gauge
MARKER_SENSORS: tuple[type[MarkerSensor], ...] = (
    PositionSensor,
    VelocitySensor,
    OrientationSensor,
    AngularVelocitySensor,
)
SENSORS: tuple[type[Sensor], ...] = (
    *(*MARKER_SENSORS, ModalSensor, ReactionSensor, StressSensor),
    *(CoordinateSensor, RateSensor, EnergySensor, SignalSensor),
)


def stress_labels(body: FlexibleBody) -> tuple[str, ...] | None:
    """Return the labels of the stress sites of a body, or None if its part knows no stress."""
    stress: Any = getattr(body.reduced, "stress", None)
    return None if stress is None else tuple(stress.labels)


def init_marker_sensor(sensor: MarkerSensor, name: str, marker: Marker) -> None:
    """Check and set the fields of a sensor on a marker."""
    problems = Problems()
    where = check_name(problems, "sensor", name)
    try:
        as_marker(where, "marker", marker)
    except InputError as error:
        problems.found.extend(error.problems)
    problems.raise_if_any()
    set_fields(sensor, name=name, marker=marker)


def init_body_sensor(sensor: BodySensor, name: str, body: FlexibleBody) -> None:
    """Check and set the fields of a sensor on a flexible body."""
    problems = Problems()
    where = check_name(problems, "sensor", name)
    checked: Any = body
    if not isinstance(checked, FlexibleBody):
        problems.add(where, f"body is {checked!r}, must be a flexible body")
    problems.raise_if_any()
    set_fields(sensor, name=name, body=body)
