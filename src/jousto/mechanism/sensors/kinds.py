"""All kinds of sensors, in the order of their documentation."""

from __future__ import annotations

from typing import TypeAlias

from jousto.mechanism.sensors.body import (
    ModalSensor,
    PrincipalStressSensor,
    SiteSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.bridge import Bridge
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.mechanism.sensors.gauge import Gauge
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
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.sensors.rosette import Rosette
from jousto.mechanism.sensors.section import SectionSensor

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
