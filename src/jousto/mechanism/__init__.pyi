# names of jo.mechanism; they are loaded from here when they are first used
from ..base.rotation_rates import rate_matrix as rate_matrix, velocity_matrix as velocity_matrix
from .beams.body import BeamDamping as BeamDamping
from .beams.stiffness import BeamSection as BeamSection
from .bodies.marker import Marker as Marker
from .contacts.collision import (
    Apart as Apart,
    CollisionShape as CollisionShape,
    Surface as Surface,
    SurfacePair as SurfacePair,
)
from .contacts.curves import (
    HertzLine as HertzLine,
    Impedance as Impedance,
    JohnsonLine as JohnsonLine,
    TableLaw as TableLaw,
)
from .contacts.ellipsoid import Ellipsoid as Ellipsoid
from .contacts.laws import (
    Hertz as Hertz,
    Impact as Impact,
    PowerLaw as PowerLaw,
    SpringDamper as SpringDamper,
)
from .contacts.shapes import (
    Bore as Bore,
    Capsule as Capsule,
    ConvexHull as ConvexHull,
    Cuboid as Cuboid,
    Cylinder as Cylinder,
    HalfSpace as HalfSpace,
    HollowSphere as HollowSphere,
    Sphere as Sphere,
    Torus as Torus,
)
from .contacts.surfaces import HeightField as HeightField, TriangleMesh as TriangleMesh
from .elastic_joint import ElasticJoint as ElasticJoint
from .event import Event as Event
from .forces.contact import Contact as Contact
from .forces.contact_set import Contacts as Contacts
from .forces.friction import Regularised as Regularised, StickSlip as StickSlip
from .forces.gear_spring import GearSpring as GearSpring, HarmonicDrive as HarmonicDrive
from .forces.line_load import LineLoad as LineLoad
from .forces.moving import MovingLoad as MovingLoad
from .forces.pid import PID as PID, SpeedPID as SpeedPID
from .forces.plastic import PlasticSpring as PlasticSpring
from .forces.rail_contact import RailContact as RailContact
from .forces.skin_contact import SkinContact as SkinContact
from .forces.slider import Slider as Slider
from .forces.springs import ModalLoad as ModalLoad
from .forces.stop import Stop as Stop
from .forces.track import TrackContact as TrackContact
from .forces.track_path import nodes_along as nodes_along
from .forces.tyre import BrushTyre as BrushTyre, MagicFormula as MagicFormula, Tyre as Tyre
from .joints.directions import ParallelAxes as ParallelAxes, Perpendicular as Perpendicular
from .joints.rails import RailWheel as RailWheel
from .joints.rolling import (
    DiscOnPlane as DiscOnPlane,
    KnifeEdge as KnifeEdge,
    RollingDisc as RollingDisc,
    RollingWheel as RollingWheel,
)
from .joints.rope_span import RopeSpan as RopeSpan
from .joints.switched import Lock as Lock, RigidStop as RigidStop
from .numbers import with_numbers as with_numbers
from .sensors.body import (
    DeformationMomentumSensor as DeformationMomentumSensor,
    ModalSensor as ModalSensor,
    PrincipalStressSensor as PrincipalStressSensor,
)
from .sensors.body_load import (
    BodyLoadSensor as BodyLoadSensor,
    ModalLoadSensor as ModalLoadSensor,
)
from .sensors.contact_force import (
    ContactForceSensor as ContactForceSensor,
    ContactPressureSensor as ContactPressureSensor,
)
from .sensors.damage import DamageSensor as DamageSensor
from .sensors.force_state import ForceStateSensor as ForceStateSensor
from .sensors.motion import (
    AccelerationPartsSensor as AccelerationPartsSensor,
    AngularAccelerationSensor as AngularAccelerationSensor,
)
from .sensors.rail_contact import RailContactSensor as RailContactSensor
from .sensors.scalar import EnergySensor as EnergySensor
from .sensors.section import SectionSensor as SectionSensor
from .sensors.state import StateSensor as StateSensor
from .signals.base import Product as Product, Sum as Sum
from .signals.switched import Switched as Switched
from .states.arithmetic import (
    Adder as Adder,
    BlockForce as BlockForce,
    DeadBand as DeadBand,
    Multiplier as Multiplier,
    Saturation as Saturation,
    Switch as Switch,
)
from .states.belt import BeltDrive as BeltDrive, Capstan as Capstan
from .states.block import Block as Block, Equations as Equations, States as States
from .states.control import PIDController as PIDController, RateLimit as RateLimit
from .states.delay import Delay as Delay
from .states.digital import (
    SampledPID as SampledPID,
    SampledTransferFunction as SampledTransferFunction,
)
from .states.expression import (
    Expression as Expression,
    absolute as absolute,
    atan as atan,
    clip as clip,
    cos as cos,
    exp as exp,
    log as log,
    maximum as maximum,
    minimum as minimum,
    rate as rate,
    sin as sin,
    smooth_step as smooth_step,
    sqrt as sqrt,
    tanh as tanh,
    time as time,
    value as value,
    where as where,
)
from .states.hysteresis import BoucWen as BoucWen, Play as Play, Relay as Relay
from .states.linear import (
    Integrator as Integrator,
    Lag as Lag,
    Lead as Lead,
    LinearSystem as LinearSystem,
    TransferFunction as TransferFunction,
)
from .states.reeving import Reeving as Reeving
from .states.sampled import Sampled as Sampled
from .states.tables import Lookup as Lookup, LookupMap as LookupMap
