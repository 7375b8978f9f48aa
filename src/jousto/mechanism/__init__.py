"""DECLARE: bodies, markers, joints, forces, signals and sensors; a mechanism checks them all."""

from jousto.mechanism.body import Body, FlexibleBody, Ground, MovingBody, RigidBody, ground
from jousto.mechanism.force import Force, Gravity, Load, Torque
from jousto.mechanism.joint import JOINTS, Fixed, Joint, Revolute, Spherical
from jousto.mechanism.marker import Marker
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.orientation import (
    Rotate,
    euler_parameters,
    exp_rotation,
    rotation_matrix,
    skew,
)
from jousto.mechanism.sensor import (
    SENSORS,
    AngularVelocitySensor,
    ModalSensor,
    OrientationSensor,
    PositionSensor,
    ReactionSensor,
    Sensor,
    StressSensor,
    VelocitySensor,
)
from jousto.mechanism.signal import SIGNALS, Harmonic, Signal, Step, Table

__all__ = [
    "JOINTS",
    "SENSORS",
    "SIGNALS",
    "AngularVelocitySensor",
    "Body",
    "Fixed",
    "FlexibleBody",
    "Force",
    "Gravity",
    "Ground",
    "Harmonic",
    "Joint",
    "Load",
    "Marker",
    "Mechanism",
    "ModalSensor",
    "MovingBody",
    "OrientationSensor",
    "PositionSensor",
    "ReactionSensor",
    "Revolute",
    "RigidBody",
    "Rotate",
    "Sensor",
    "Signal",
    "Spherical",
    "Step",
    "StressSensor",
    "Table",
    "Torque",
    "VelocitySensor",
    "euler_parameters",
    "exp_rotation",
    "ground",
    "rotation_matrix",
    "skew",
]
