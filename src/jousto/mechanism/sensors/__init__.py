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
    StrainSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.gauges import (
    ENERGIES,
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
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

BodySensor: TypeAlias = ModalSensor | SiteSensor | StrainSensor
Gauge: TypeAlias = CoordinateSensor | RateSensor | EnergySensor | SignalSensor
Sensor: TypeAlias = MotionSensor | BodySensor | ReactionSensor | ForceSensor | Gauge
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
    StrainSensor,
)
SENSORS: tuple[type[Sensor], ...] = (
    *(*MOTION_SENSORS, *BODY_SENSORS, ReactionSensor, ForceSensor),
    *(CoordinateSensor, RateSensor, EnergySensor, SignalSensor),
)

__all__ = [
    "BODY_SENSORS",
    "ENERGIES",
    "MOTION_SENSORS",
    "SENSORS",
    "AccelerationSensor",
    "AngularAccelerationSensor",
    "AngularVelocitySensor",
    "BodySensor",
    "CoordinateSensor",
    "EnergySensor",
    "ForceSensor",
    "Gauge",
    "ModalSensor",
    "MotionSensor",
    "OrientationSensor",
    "PositionSensor",
    "PrincipalStressSensor",
    "RateSensor",
    "ReactionSensor",
    "Sensor",
    "SignalSensor",
    "SiteSensor",
    "StrainSensor",
    "StressSensor",
    "VelocitySensor",
    "VonMisesSensor",
]
