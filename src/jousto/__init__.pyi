# the public names; __init__.py loads them from here when they are first used
from . import planar as planar
from .base.errors import (
    InputError as InputError,
    JoustoError as JoustoError,
    JoustoWarning as JoustoWarning,
    Problem as Problem,
    SimulationError as SimulationError,
)
from .base.rotations import Rotate as Rotate
from .fatigue.contact.contact import (
    HertzContact as HertzContact,
    RollingContact as RollingContact,
    hertz_line as hertz_line,
    hertz_point as hertz_point,
    rolling_contact as rolling_contact,
    shakedown_limit as shakedown_limit,
)
from .fatigue.contact.rolling import RollingLife as RollingLife, rolling_life as rolling_life
from .fatigue.cycles.duty import DutyCycle as DutyCycle, DutyEvent as DutyEvent
from .fatigue.cycles.rainflow import (
    Cycles as Cycles,
    RainflowMatrix as RainflowMatrix,
    rainflow as rainflow,
)
from .fatigue.local.strain_life import (
    LocalCycles as LocalCycles,
    LocalPath as LocalPath,
    StrainDamage as StrainDamage,
    glinka as glinka,
    local_cycles as local_cycles,
    local_path as local_path,
    neuber as neuber,
    strain_damage as strain_damage,
)
from .fatigue.miner.damage import (
    Assessment as Assessment,
    assess as assess,
    damage as damage,
    life as life,
    stress_safety as stress_safety,
)
from .fatigue.miner.damage_field import (
    DamageField as DamageField,
    damage_field as damage_field,
    site_cycles as site_cycles,
)
from .fatigue.multiaxial.counted_planes import (
    PlaneDamage as PlaneDamage,
    plane_damage as plane_damage,
)
from .fatigue.multiaxial.planes import (
    CriticalPlane as CriticalPlane,
    DangVan as DangVan,
    FatemiSocie as FatemiSocie,
    Findley as Findley,
    Multiaxial as Multiaxial,
    NormalStress as NormalStress,
    critical_plane as critical_plane,
    multiaxial as multiaxial,
)
from .fatigue.random.random_response import (
    RandomResponse as RandomResponse,
    SpectralLife as SpectralLife,
    random_response as random_response,
)
from .fatigue.random.spectral import (
    SpectralDamage as SpectralDamage,
    spectral_damage as spectral_damage,
    spectral_moments as spectral_moments,
    synthesise as synthesise,
)
from .fatigue.welds.toes import (
    WeldToe as WeldToe,
    hot_spot_stress as hot_spot_stress,
    weld_stress as weld_stress,
)
from .materials.library import material as material, materials as materials
from .materials.material import Material as Material
from .materials.orthotropic import Orthotropic as Orthotropic
from .materials.strength.factors import (
    finish_factor as finish_factor,
    load_factor as load_factor,
    reliability_factor as reliability_factor,
    roughness_factor as roughness_factor,
    size_factor as size_factor,
)
from .materials.strength.mean_stress import (
    FKM as FKM,
    SWT as SWT,
    Gerber as Gerber,
    Goodman as Goodman,
    MeanStress as MeanStress,
    Morrow as Morrow,
    PartCompression as PartCompression,
    Soderberg as Soderberg,
    Walker as Walker,
    WeldRatio as WeldRatio,
)
from .materials.strength.sn import SN as SN
from .materials.strength.sn_library import (
    estimate_sn as estimate_sn,
    sn_curve as sn_curve,
    sn_curves as sn_curves,
)
from .materials.strength.strain_life import (
    StrainLife as StrainLife,
    strain_life as strain_life,
    strain_lives as strain_lives,
)
from .materials.strength.welds import fat_class as fat_class, thickness_factor as thickness_factor
from .measurement.gauges.align import Alignment as Alignment, align as align
from .measurement.gauges.compare import (
    GaugeComparison as GaugeComparison,
    GaugePair as GaugePair,
    compare_gauges as compare_gauges,
)
from .measurement.gauges.read import read_record as read_record
from .measurement.gauges.record import Record as Record, record_of as record_of
from .measurement.gauges.rosettes import (
    RosetteState as RosetteState,
    rosette_state as rosette_state,
)
from .measurement.monitor.alarms import AlarmLimits as AlarmLimits
from .measurement.monitor.health import ChannelRules as ChannelRules
from .measurement.monitor.monitor import Monitor as Monitor
from .measurement.monitor.recorded import MonitorRecord as MonitorRecord
from .measurement.monitor.setup import MonitorSettings as MonitorSettings
from .measurement.monitor.watch import watch as watch
from .measurement.twin.bands import stress_band as stress_band
from .measurement.twin.life import DamageBand as DamageBand, damage_band as damage_band
from .measurement.twin.loads import (
    identify_fourier as identify_fourier,
    identify_loads as identify_loads,
    identify_payload as identify_payload,
)
from .measurement.twin.observed import Observed as Observed
from .measurement.twin.observer import Balance as Balance, Observer as Observer
from .measurement.twin.placement import Placement as Placement, place_gauges as place_gauges
from .measurement.twin.reconstruction import Estimate as Estimate, Reconstruction as Reconstruction
from .measurement.twin.reference import Reference as Reference
from .measurement.twin.system import Accelerometer as Accelerometer, UnknownLoad as UnknownLoad
from .measurement.twin.tolerance import gauge_errors as gauge_errors
from .measurement.twin.tuning import innovation_test as innovation_test
from .mechanism.beams.body import BeamBody as BeamBody, BeamDamping as BeamDamping
from .mechanism.beams.stiffness import BeamSection as BeamSection
from .mechanism.bodies.body import (
    FlexibleBody as FlexibleBody,
    RigidBody as RigidBody,
    ground as ground,
)
from .mechanism.forces.friction import (
    Friction as Friction,
    Regularised as Regularised,
    StickSlip as StickSlip,
)
from .mechanism.forces.line_load import LineLoad as LineLoad
from .mechanism.forces.loads import Force as Force, Gravity as Gravity, Torque as Torque
from .mechanism.forces.moving import MovingLoad as MovingLoad
from .mechanism.forces.springs import (
    Bushing as Bushing,
    JointForce as JointForce,
    ModalLoad as ModalLoad,
    Servo as Servo,
    Spring as Spring,
    UserForce as UserForce,
)
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
from .mechanism.sensors.body import (
    ModalSensor as ModalSensor,
    PrincipalStressSensor as PrincipalStressSensor,
    StressSensor as StressSensor,
    VonMisesSensor as VonMisesSensor,
)
from .mechanism.sensors.bridge import (
    Bridge as Bridge,
    bridge_output as bridge_output,
    quarter_bridge_strain as quarter_bridge_strain,
)
from .mechanism.sensors.damage import DamageSensor as DamageSensor
from .mechanism.sensors.gauge import Gauge as Gauge, gauge_rows as gauge_rows
from .mechanism.sensors.loads import ForceSensor as ForceSensor, ReactionSensor as ReactionSensor
from .mechanism.sensors.motion import (
    AccelerationSensor as AccelerationSensor,
    AngularAccelerationSensor as AngularAccelerationSensor,
    AngularVelocitySensor as AngularVelocitySensor,
    OrientationSensor as OrientationSensor,
    PositionSensor as PositionSensor,
    VelocitySensor as VelocitySensor,
)
from .mechanism.sensors.readings import (
    CoordinateSensor as CoordinateSensor,
    EnergySensor as EnergySensor,
    RateSensor as RateSensor,
    SignalSensor as SignalSensor,
)
from .mechanism.sensors.rosette import Rosette as Rosette
from .mechanism.sensors.section import SectionSensor as SectionSensor
from .mechanism.sensors.temperature import Temperature as Temperature
from .mechanism.signals.base import (
    Constant as Constant,
    ConstantSpeed as ConstantSpeed,
    Input as Input,
    Product as Product,
    Sum as Sum,
)
from .mechanism.signals.event import Event as Event
from .mechanism.signals.harmonic import Harmonic as Harmonic
from .mechanism.signals.piecewise import (
    Ramp as Ramp,
    SCurve as SCurve,
    Step as Step,
    Table as Table,
)
from .mechanism.signals.switched import Switched as Switched
from .mesh.cells import Cells as Cells
from .mesh.holes import Hole as Hole
from .mesh.inspection import Finding as Finding
from .mesh.mesh import Mesh as Mesh
from .mesh.picks import (
    InBox as InBox,
    InCylinder as InCylinder,
    InSphere as InSphere,
    Nearest as Nearest,
)
from .mesh.quality import Quality as Quality
from .mesh.readers.files import read_mesh as read_mesh
from .mesh.readers.step import mesh_step as mesh_step
from .model.compile import compile as compile
from .model.model import Model as Model
from .model.native.meter import DamageMeter as DamageMeter
from .model.native.native import Engine as Engine
from .model.rank.doctor import Diagnosis as Diagnosis, doctor as doctor
from .output.plot import plot as plot
from .output.scenes.animate import animate as animate, still as still
from .output.scenes.draw import draw as draw
from .output.write import write as write
from .parts.frames.element import EulerBernoulli as EulerBernoulli, Timoshenko as Timoshenko
from .parts.frames.members import Member as Member
from .parts.interface import Interface as Interface
from .parts.loads import (
    NodalForce as NodalForce,
    Pressure as Pressure,
    Spin as Spin,
    SurfaceLoad as SurfaceLoad,
    Traction as Traction,
    Weight as Weight,
)
from .parts.mass import PointMass as PointMass
from .parts.matrices.matrices import Matrices as Matrices
from .parts.matrices.read import read_matrices as read_matrices
from .parts.part import Part as Part
from .parts.solids.error import (
    MeshError as MeshError,
    mesh_error as mesh_error,
    place_errors as place_errors,
)
from .planar.frame import PlanarFrame as PlanarFrame
from .recovery.beams.forces import SectionForces as SectionForces, section_forces as section_forces
from .recovery.budget import ErrorBudget as ErrorBudget, error_budget as error_budget
from .recovery.fields.build import field_from as field_from, stress_field as stress_field
from .recovery.fields.criteria import Plane as Plane
from .recovery.fields.field import Envelope as Envelope, StressField as StressField
from .recovery.friction import (
    FrictionStress as FrictionStress,
    friction_stress as friction_stress,
    without_friction as without_friction,
)
from .recovery.hotspots.found import HotSpot as HotSpot
from .recovery.hotspots.spots import HotSpots as HotSpots, hot_spots as hot_spots
from .reduction.certificate.advice import Advice as Advice, advise as advise
from .reduction.certificate.certificate import Certificate as Certificate, Check as Check
from .reduction.certificate.certify import certify as certify
from .reduction.clamp import clamp as clamp
from .reduction.damping import Rayleigh as Rayleigh
from .reduction.files.cache import ReductionCache as ReductionCache
from .reduction.methods import CraigBampton as CraigBampton, FreeFree as FreeFree
from .reduction.modes.relief import InertiaRelief as InertiaRelief, inertia_relief as inertia_relief
from .reduction.reduced import ReducedPart as ReducedPart
from .reduction.reducer import from_modes as from_modes, reduce as reduce
from .reduction.sparse.factor import SolverInfo as SolverInfo, solvers as solvers
from .reduction.sparse.memory import (
    MemoryEstimate as MemoryEstimate,
    memory_estimate as memory_estimate,
)
from .reduction.superelement import reduce_superelement as reduce_superelement
from .schema.file.read import read_model as read_model
from .sections.points import StressPoint as StressPoint
from .sections.profiles import Box as Box, IBeam as IBeam
from .sections.section import (
    Circle as Circle,
    GeneralSection as GeneralSection,
    Rectangle as Rectangle,
    SectionPoint as SectionPoint,
    Tube as Tube,
)
from .simulation.kinematics import inverse_dynamics as inverse_dynamics, kinematics as kinematics
from .simulation.modes.campbell import Campbell as Campbell, campbell as campbell
from .simulation.modes.linear import (
    LinearModel as LinearModel,
    MechanismModes as MechanismModes,
    linearise as linearise,
    modes as modes,
)
from .simulation.results.events import Happening as Happening
from .simulation.results.solution import Solution as Solution, load as load
from .simulation.running.simulate import (
    RunFailed as RunFailed,
    RunInterrupted as RunInterrupted,
    simulate as simulate,
)
from .simulation.running.simulator import Simulator as Simulator
from .simulation.running.state import State as State
from .simulation.solvers.adaptive import DormandPrince as DormandPrince
from .simulation.solvers.explicit import RK4 as RK4, ROS2 as ROS2, Baumgarte as Baumgarte
from .simulation.solvers.implicit import GeneralizedAlpha as GeneralizedAlpha, Newmark as Newmark
from .simulation.statics.buckling import Buckling as Buckling, buckling as buckling
from .simulation.statics.equilibrium import equilibrium as equilibrium
from .simulation.statics.load_paths import (
    ArcLength as ArcLength,
    CriticalPoint as CriticalPoint,
    LoadPath as LoadPath,
    PathFailed as PathFailed,
)
from .simulation.statics.paths import load_path as load_path
from .simulation.statics.rotation import steady_rotation as steady_rotation
from .simulation.statics.settled import settled as settled

__version__: str
