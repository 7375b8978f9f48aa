"""Sensors: what the engine records while it steps.

Every sensor says its `unit`, the names of its `components`, the `frame` that they are resolved in
and a `description` for results and plots.
"""

from __future__ import annotations

from typing import TypeAlias

from jousto.mechanism.sensors.body import (
    ModalSensor,
    PrincipalStressSensor,
    SiteSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.bridge import Bridge, bridge_output, quarter_bridge_strain
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.mechanism.sensors.gauge import Gauge, gauge_rows
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import (
    AccelerationSensor,
    AngularAccelerationSensor,
    AngularVelocitySensor,
    MotionSensor,
    OrientationSensor,
    PositionSensor,
    VelocitySensor,
)
from jousto.mechanism.sensors.readings import (
    ENERGIES,
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.sensors.rosette import Rosette
from jousto.mechanism.sensors.section import SectionSensor
from jousto.mechanism.sensors.temperature import Temperature

BodySensor: TypeAlias = ModalSensor | SiteSensor | Gauge | Rosette | Bridge | SectionSensor
Reading: TypeAlias = CoordinateSensor | RateSensor | EnergySensor | SignalSensor
Sensor: TypeAlias = (
    MotionSensor | BodySensor | ReactionSensor | ForceSensor | Reading | DamageSensor
)
MOTION_SENSORS: tuple[type[MotionSensor], ...] = (
    PositionSensor,
    VelocitySensor,
    AccelerationSensor,
    OrientationSensor,
    AngularVelocitySensor,
    AngularAccelerationSensor,
)
BODY_SENSORS: tuple[type[BodySensor], ...] = (
    ModalSensor,
    StressSensor,
    VonMisesSensor,
    PrincipalStressSensor,
    Gauge,
    Rosette,
    Bridge,
    SectionSensor,
)
SENSORS: tuple[type[Sensor], ...] = (
    *(*MOTION_SENSORS, *BODY_SENSORS, ReactionSensor, ForceSensor),
    *(CoordinateSensor, RateSensor, EnergySensor, SignalSensor, DamageSensor),
)

__all__ = [
    "BODY_SENSORS",
    "ENERGIES",
    "MOTION_SENSORS",
    "SENSORS",
    "AccelerationSensor",
    "Bridge",
    "Rosette",
    "Temperature",
    "bridge_output",
    "quarter_bridge_strain",
    "AngularAccelerationSensor",
    "AngularVelocitySensor",
    "BodySensor",
    "CoordinateSensor",
    "DamageSensor",
    "EnergySensor",
    "ForceSensor",
    "Gauge",
    "ModalSensor",
    "MotionSensor",
    "OrientationSensor",
    "PositionSensor",
    "PrincipalStressSensor",
    "RateSensor",
    "Reading",
    "ReactionSensor",
    "SectionSensor",
    "Sensor",
    "SignalSensor",
    "SiteSensor",
    "StressSensor",
    "VelocitySensor",
    "VonMisesSensor",
    "gauge_rows",
]
