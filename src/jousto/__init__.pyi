# the public names; they are loaded from here when they are first used
from . import (
    certificate as certificate,
    design as design,
    export as export,
    fatigue as fatigue,
    materials as materials,
    mechanism as mechanism,
    mesh as mesh,
    model as model,
    natural as natural,
    parts as parts,
    planar as planar,
    recovery as recovery,
    reduction as reduction,
    robots as robots,
    sections as sections,
    simulation as simulation,
)
from .base.errors import (
    InputError as InputError,
    JoustoError as JoustoError,
    JoustoWarning as JoustoWarning,
    SimulationError as SimulationError,
)
from .base.rotations import Rotate as Rotate
from .base.version import __version__ as __version__
from .certificate.doctor import doctor as doctor
from .design.studies.parameters.parameter import Parameter as Parameter
from .design.studies.study import study as study
from .fatigue.miner.damage_field import damage_field as damage_field
from .materials.library import material as material
from .materials.material import Material as Material
from .materials.strength.sn import SN as SN
from .materials.strength.sn_library import sn_curve as sn_curve
from .measurement import gauges as gauges, monitor as monitor, twin as twin
from .mechanism import electric as electric, hydraulics as hydraulics
from .mechanism.beams.body import BeamBody as BeamBody
from .mechanism.bodies.body import (
    FlexibleBody as FlexibleBody,
    RigidBody as RigidBody,
    ground as ground,
)
from .mechanism.forces.friction import Friction as Friction
from .mechanism.forces.loads import Force as Force, Gravity as Gravity, Torque as Torque
from .mechanism.forces.springs import (
    Bushing as Bushing,
    JointForce as JointForce,
    Servo as Servo,
    Spring as Spring,
    UserForce as UserForce,
)
from .mechanism.foreign.fmu import Fmu as Fmu
from .mechanism.initial import Initial as Initial
from .mechanism.joints.coordinate import (
    Angle as Angle,
    Displacement as Displacement,
    Distance as Distance,
)
from .mechanism.joints.coupling import (
    Coupling as Coupling,
    Drive as Drive,
    Gear as Gear,
    Rack as Rack,
)
from .mechanism.joints.hinges import (
    Cylindrical as Cylindrical,
    Revolute as Revolute,
    Screw as Screw,
    Universal as Universal,
)
from .mechanism.joints.points import (
    PointOnLine as PointOnLine,
    PointOnPlane as PointOnPlane,
    Rod as Rod,
    Spherical as Spherical,
)
from .mechanism.joints.slides import (
    ConstantOrientation as ConstantOrientation,
    Fixed as Fixed,
    Planar as Planar,
    Prismatic as Prismatic,
)
from .mechanism.mechanism import Mechanism as Mechanism
from .mechanism.sensors.body import StressSensor as StressSensor, VonMisesSensor as VonMisesSensor
from .mechanism.sensors.loads import ForceSensor as ForceSensor, ReactionSensor as ReactionSensor
from .mechanism.sensors.motion import (
    AccelerationSensor as AccelerationSensor,
    AngularVelocitySensor as AngularVelocitySensor,
    OrientationSensor as OrientationSensor,
    PositionSensor as PositionSensor,
    VelocitySensor as VelocitySensor,
)
from .mechanism.sensors.scalar import (
    CoordinateSensor as CoordinateSensor,
    RateSensor as RateSensor,
    SignalSensor as SignalSensor,
)
from .mechanism.signals.base import (
    Constant as Constant,
    ConstantSpeed as ConstantSpeed,
    Input as Input,
)
from .mechanism.signals.harmonic import Harmonic as Harmonic
from .mechanism.signals.piecewise import (
    Ramp as Ramp,
    SCurve as SCurve,
    Step as Step,
    Table as Table,
)
from .mesh.mesh import Mesh as Mesh
from .mesh.readers.files import read_mesh as read_mesh
from .mesh.readers.step import mesh_cad as mesh_cad
from .model.compile import compile as compile
from .model.model import Model as Model
from .natural.verify import verify as verify
from .output.plot import plot as plot
from .output.scenes.animate import animate as animate, still as still
from .output.scenes.draw import draw as draw
from .output.write import write as write
from .parts.frames.members import Member as Member
from .parts.interface import Interface as Interface
from .parts.part import Part as Part
from .recovery.fields.build import stress_field as stress_field
from .recovery.hotspots.hot_spots import hot_spots as hot_spots
from .reduction.damping import Rayleigh as Rayleigh
from .reduction.methods import CraigBampton as CraigBampton, FreeFree as FreeFree
from .reduction.reduced import ReducedPart as ReducedPart
from .reduction.reducer import reduce as reduce
from .schema.read import read_model as read_model
from .sections.profiles import Box as Box, IBeam as IBeam
from .sections.section import Circle as Circle, Rectangle as Rectangle, Tube as Tube
from .simulation.modes.linear import modes as modes
from .simulation.results.solution import Solution as Solution, load as load
from .simulation.running.simulate import simulate as simulate
from .simulation.solvers.implicit import GeneralizedAlpha as GeneralizedAlpha
from .simulation.solvers.rosenbrock import ROS2 as ROS2
from .simulation.solvers.runge_kutta import RK4 as RK4
from .simulation.statics.equilibrium import equilibrium as equilibrium
from .viewer.live.live import live as live
from .viewer.view import view as view
