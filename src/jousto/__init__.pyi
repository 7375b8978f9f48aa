# the public names; __init__.py loads them from here when they are first used
from . import planar as planar
from .engine import DamageMeter as DamageMeter
from .engine import Diagnosis as Diagnosis
from .engine import Engine as Engine
from .engine import Model as Model
from .engine import compile as compile
from .engine import doctor as doctor
from .errors import (
    InputError as InputError,
)
from .errors import (
    JoustoError as JoustoError,
)
from .errors import (
    JoustoWarning as JoustoWarning,
)
from .errors import (
    Problem as Problem,
)
from .errors import (
    SimulationError as SimulationError,
)
from .mechanism import (
    AccelerationSensor as AccelerationSensor,
)
from .mechanism import (
    Angle as Angle,
)
from .mechanism import (
    AngularAccelerationSensor as AngularAccelerationSensor,
)
from .mechanism import (
    AngularVelocitySensor as AngularVelocitySensor,
)
from .mechanism import (
    BeamBody as BeamBody,
)
from .mechanism import (
    BeamDamping as BeamDamping,
)
from .mechanism import (
    BeamSection as BeamSection,
)
from .mechanism import Bridge as Bridge
from .mechanism import (
    Bushing as Bushing,
)
from .mechanism import (
    Constant as Constant,
)
from .mechanism import (
    ConstantOrientation as ConstantOrientation,
)
from .mechanism import (
    ConstantSpeed as ConstantSpeed,
)
from .mechanism import (
    CoordinateSensor as CoordinateSensor,
)
from .mechanism import (
    Coupling as Coupling,
)
from .mechanism import (
    Cylindrical as Cylindrical,
)
from .mechanism import (
    DamageSensor as DamageSensor,
)
from .mechanism import (
    Displacement as Displacement,
)
from .mechanism import (
    Distance as Distance,
)
from .mechanism import (
    Drive as Drive,
)
from .mechanism import (
    EnergySensor as EnergySensor,
)
from .mechanism import (
    Event as Event,
)
from .mechanism import (
    Fixed as Fixed,
)
from .mechanism import (
    FlexibleBody as FlexibleBody,
)
from .mechanism import (
    Force as Force,
)
from .mechanism import (
    ForceSensor as ForceSensor,
)
from .mechanism import (
    Friction as Friction,
)
from .mechanism import (
    Gauge as Gauge,
)
from .mechanism import (
    Gear as Gear,
)
from .mechanism import (
    Gravity as Gravity,
)
from .mechanism import (
    Harmonic as Harmonic,
)
from .mechanism import (
    Initial as Initial,
)
from .mechanism import (
    Input as Input,
)
from .mechanism import (
    JointForce as JointForce,
)
from .mechanism import (
    LineLoad as LineLoad,
)
from .mechanism import (
    Mechanism as Mechanism,
)
from .mechanism import (
    ModalLoad as ModalLoad,
)
from .mechanism import (
    ModalSensor as ModalSensor,
)
from .mechanism import (
    MovingLoad as MovingLoad,
)
from .mechanism import (
    OrientationSensor as OrientationSensor,
)
from .mechanism import (
    Planar as Planar,
)
from .mechanism import (
    PointOnLine as PointOnLine,
)
from .mechanism import (
    PointOnPlane as PointOnPlane,
)
from .mechanism import (
    PositionSensor as PositionSensor,
)
from .mechanism import (
    PrincipalStressSensor as PrincipalStressSensor,
)
from .mechanism import (
    Prismatic as Prismatic,
)
from .mechanism import (
    Product as Product,
)
from .mechanism import (
    Rack as Rack,
)
from .mechanism import (
    Ramp as Ramp,
)
from .mechanism import (
    RateSensor as RateSensor,
)
from .mechanism import (
    ReactionSensor as ReactionSensor,
)
from .mechanism import (
    Regularised as Regularised,
)
from .mechanism import (
    Revolute as Revolute,
)
from .mechanism import (
    RigidBody as RigidBody,
)
from .mechanism import (
    Rod as Rod,
)
from .mechanism import Rosette as Rosette
from .mechanism import (
    Rotate as Rotate,
)
from .mechanism import (
    Screw as Screw,
)
from .mechanism import (
    SCurve as SCurve,
)
from .mechanism import (
    SectionSensor as SectionSensor,
)
from .mechanism import (
    Servo as Servo,
)
from .mechanism import (
    SignalSensor as SignalSensor,
)
from .mechanism import (
    Spherical as Spherical,
)
from .mechanism import (
    Spring as Spring,
)
from .mechanism import (
    Step as Step,
)
from .mechanism import (
    StickSlip as StickSlip,
)
from .mechanism import (
    StressSensor as StressSensor,
)
from .mechanism import (
    Sum as Sum,
)
from .mechanism import (
    Switched as Switched,
)
from .mechanism import (
    Table as Table,
)
from .mechanism import Temperature as Temperature
from .mechanism import (
    Torque as Torque,
)
from .mechanism import (
    Universal as Universal,
)
from .mechanism import (
    UserForce as UserForce,
)
from .mechanism import (
    VelocitySensor as VelocitySensor,
)
from .mechanism import (
    VonMisesSensor as VonMisesSensor,
)
from .mechanism import bridge_output as bridge_output
from .mechanism import (
    gauge_rows as gauge_rows,
)
from .mechanism import (
    ground as ground,
)
from .mechanism import quarter_bridge_strain as quarter_bridge_strain
from .output import animate as animate
from .output import plot as plot
from .output import (
    plot_band as plot_band,
)
from .output import (
    plot_beam as plot_beam,
)
from .output import plot_campbell as plot_campbell
from .output import plot_friction_stress as plot_friction_stress
from .output import plot_gauges as plot_gauges
from .output import plot_hotspots as plot_hotspots
from .output import (
    plot_hysteresis as plot_hysteresis,
)
from .output import plot_load_path as plot_load_path
from .output import plot_monitor as plot_monitor
from .output import plot_planar as plot_planar
from .output import plot_root_locus as plot_root_locus
from .output import (
    plot_section_forces as plot_section_forces,
)
from .output import (
    plot_spectrum as plot_spectrum,
)
from .output import plot_stress as plot_stress
from .output import still as still
from .output import (
    write_beam as write_beam,
)
from .output import write_certificate as write_certificate
from .output import (
    write_contour as write_contour,
)
from .output import (
    write_fem as write_fem,
)
from .output import write_hotspots as write_hotspots
from .output import (
    write_sid as write_sid,
)
from .output import write_stress as write_stress
from .output import (
    write_vtu as write_vtu,
)
from .parts import (
    Box as Box,
)
from .parts import (
    Cells as Cells,
)
from .parts import (
    Circle as Circle,
)
from .parts import (
    EulerBernoulli as EulerBernoulli,
)
from .parts import (
    Finding as Finding,
)
from .parts import (
    GeneralSection as GeneralSection,
)
from .parts import (
    Hole as Hole,
)
from .parts import (
    IBeam as IBeam,
)
from .parts import (
    InBox as InBox,
)
from .parts import (
    InCylinder as InCylinder,
)
from .parts import (
    InSphere as InSphere,
)
from .parts import (
    Interface as Interface,
)
from .parts import (
    Material as Material,
)
from .parts import (
    Member as Member,
)
from .parts import (
    Mesh as Mesh,
)
from .parts import (
    MeshError as MeshError,
)
from .parts import (
    Nearest as Nearest,
)
from .parts import (
    NodalForce as NodalForce,
)
from .parts import (
    Orthotropic as Orthotropic,
)
from .parts import (
    Part as Part,
)
from .parts import (
    PointMass as PointMass,
)
from .parts import (
    Pressure as Pressure,
)
from .parts import (
    Quality as Quality,
)
from .parts import (
    Rectangle as Rectangle,
)
from .parts import (
    SectionPoint as SectionPoint,
)
from .parts import (
    Spin as Spin,
)
from .parts import (
    StressPoint as StressPoint,
)
from .parts import (
    SurfaceLoad as SurfaceLoad,
)
from .parts import (
    Timoshenko as Timoshenko,
)
from .parts import (
    Traction as Traction,
)
from .parts import (
    Tube as Tube,
)
from .parts import (
    Weight as Weight,
)
from .parts import (
    material as material,
)
from .parts import (
    materials as materials,
)
from .parts import (
    mesh_error as mesh_error,
)
from .parts import (
    mesh_step as mesh_step,
)
from .parts import (
    place_errors as place_errors,
)
from .parts import (
    read_mesh as read_mesh,
)
from .parts.readers.matrices import (
    Matrices as Matrices,
)
from .parts.readers.matrices import (
    read_matrices as read_matrices,
)
from .parts.strain_life import (
    StrainLife as StrainLife,
)
from .parts.strain_life import (
    strain_life as strain_life,
)
from .parts.strain_life import (
    strain_lives as strain_lives,
)
from .parts.toes import (
    WeldToe as WeldToe,
)
from .parts.toes import (
    hot_spot_stress as hot_spot_stress,
)
from .parts.toes import (
    weld_stress as weld_stress,
)
from .recovery import Alignment as Alignment
from .recovery import (
    Envelope as Envelope,
)
from .recovery import (
    ErrorBudget as ErrorBudget,
)
from .recovery import (
    FrictionStress as FrictionStress,
)
from .recovery import GaugeComparison as GaugeComparison
from .recovery import GaugePair as GaugePair
from .recovery import (
    HotSpot as HotSpot,
)
from .recovery import (
    HotSpots as HotSpots,
)
from .recovery import (
    Plane as Plane,
)
from .recovery import Record as Record
from .recovery import RosetteState as RosetteState
from .recovery import (
    SectionForces as SectionForces,
)
from .recovery import (
    StressField as StressField,
)
from .recovery import compare_gauges as compare_gauges
from .recovery import (
    error_budget as error_budget,
)
from .recovery import (
    field_from as field_from,
)
from .recovery import (
    friction_stress as friction_stress,
)
from .recovery import (
    hot_spots as hot_spots,
)
from .recovery import read_record as read_record
from .recovery import record_of as record_of
from .recovery import rosette_state as rosette_state
from .recovery import (
    section_forces as section_forces,
)
from .recovery import (
    stress_field as stress_field,
)
from .recovery import (
    without_friction as without_friction,
)
from .recovery.fatigue.contact import (
    HertzContact as HertzContact,
)
from .recovery.fatigue.contact import (
    RollingContact as RollingContact,
)
from .recovery.fatigue.contact import (
    hertz_line as hertz_line,
)
from .recovery.fatigue.contact import (
    hertz_point as hertz_point,
)
from .recovery.fatigue.contact import (
    rolling_contact as rolling_contact,
)
from .recovery.fatigue.contact import (
    shakedown_limit as shakedown_limit,
)
from .recovery.fatigue.counted_planes import (
    PlaneDamage as PlaneDamage,
)
from .recovery.fatigue.counted_planes import (
    plane_damage as plane_damage,
)
from .recovery.fatigue.planes import (
    CriticalPlane as CriticalPlane,
)
from .recovery.fatigue.planes import (
    DangVan as DangVan,
)
from .recovery.fatigue.planes import (
    FatemiSocie as FatemiSocie,
)
from .recovery.fatigue.planes import (
    Findley as Findley,
)
from .recovery.fatigue.planes import (
    Multiaxial as Multiaxial,
)
from .recovery.fatigue.planes import (
    NormalStress as NormalStress,
)
from .recovery.fatigue.planes import (
    critical_plane as critical_plane,
)
from .recovery.fatigue.planes import (
    multiaxial as multiaxial,
)
from .recovery.fatigue.random_response import (
    RandomResponse as RandomResponse,
)
from .recovery.fatigue.random_response import (
    SpectralLife as SpectralLife,
)
from .recovery.fatigue.random_response import (
    random_response as random_response,
)
from .recovery.fatigue.rolling import (
    RollingLife as RollingLife,
)
from .recovery.fatigue.rolling import (
    rolling_life as rolling_life,
)
from .recovery.fatigue.spectral import (
    SpectralDamage as SpectralDamage,
)
from .recovery.fatigue.spectral import (
    spectral_damage as spectral_damage,
)
from .recovery.fatigue.spectral import (
    spectral_moments as spectral_moments,
)
from .recovery.fatigue.spectral import (
    synthesise as synthesise,
)
from .recovery.fatigue.strain_life import (
    LocalCycles as LocalCycles,
)
from .recovery.fatigue.strain_life import (
    LocalPath as LocalPath,
)
from .recovery.fatigue.strain_life import (
    StrainDamage as StrainDamage,
)
from .recovery.fatigue.strain_life import (
    glinka as glinka,
)
from .recovery.fatigue.strain_life import (
    local_cycles as local_cycles,
)
from .recovery.fatigue.strain_life import (
    local_path as local_path,
)
from .recovery.fatigue.strain_life import (
    neuber as neuber,
)
from .recovery.fatigue.strain_life import (
    strain_damage as strain_damage,
)
from .recovery.monitor import (
    AlarmLimits as AlarmLimits,
)
from .recovery.monitor import (
    ChannelRules as ChannelRules,
)
from .recovery.monitor import (
    Monitor as Monitor,
)
from .recovery.monitor import (
    MonitorRecord as MonitorRecord,
)
from .recovery.monitor import (
    MonitorSettings as MonitorSettings,
)
from .recovery.monitor import (
    watch as watch,
)
from .recovery.twin import (
    Accelerometer as Accelerometer,
)
from .recovery.twin import (
    Balance as Balance,
)
from .recovery.twin import (
    DamageBand as DamageBand,
)
from .recovery.twin import (
    Estimate as Estimate,
)
from .recovery.twin import (
    Observed as Observed,
)
from .recovery.twin import (
    Observer as Observer,
)
from .recovery.twin import (
    Placement as Placement,
)
from .recovery.twin import (
    Reconstruction as Reconstruction,
)
from .recovery.twin import (
    Reference as Reference,
)
from .recovery.twin import (
    UnknownLoad as UnknownLoad,
)
from .recovery.twin import (
    damage_band as damage_band,
)
from .recovery.twin import (
    gauge_errors as gauge_errors,
)
from .recovery.twin import (
    identify_fourier as identify_fourier,
)
from .recovery.twin import (
    identify_loads as identify_loads,
)
from .recovery.twin import (
    identify_payload as identify_payload,
)
from .recovery.twin import (
    innovation_test as innovation_test,
)
from .recovery.twin import (
    place_gauges as place_gauges,
)
from .recovery.twin import (
    stress_band as stress_band,
)
from .reduction import (
    Advice as Advice,
)
from .reduction import (
    Certificate as Certificate,
)
from .reduction import (
    Check as Check,
)
from .reduction import (
    CraigBampton as CraigBampton,
)
from .reduction import (
    FreeFree as FreeFree,
)
from .reduction import (
    InertiaRelief as InertiaRelief,
)
from .reduction import (
    MemoryEstimate as MemoryEstimate,
)
from .reduction import (
    Rayleigh as Rayleigh,
)
from .reduction import (
    ReducedPart as ReducedPart,
)
from .reduction import (
    ReductionCache as ReductionCache,
)
from .reduction import (
    SolverInfo as SolverInfo,
)
from .reduction import (
    advise as advise,
)
from .reduction import (
    certify as certify,
)
from .reduction import (
    clamp as clamp,
)
from .reduction import (
    inertia_relief as inertia_relief,
)
from .reduction import (
    memory_estimate as memory_estimate,
)
from .reduction import (
    reduce as reduce,
)
from .reduction import (
    reduce_superelement as reduce_superelement,
)
from .reduction import (
    solvers as solvers,
)
from .schema import read_model as read_model
from .simulation import (
    RK4 as RK4,
)
from .simulation import (
    ROS2 as ROS2,
)
from .simulation import (
    ArcLength as ArcLength,
)
from .simulation import (
    Baumgarte as Baumgarte,
)
from .simulation import (
    Buckling as Buckling,
)
from .simulation import (
    Campbell as Campbell,
)
from .simulation import (
    CriticalPoint as CriticalPoint,
)
from .simulation import (
    DormandPrince as DormandPrince,
)
from .simulation import (
    GeneralizedAlpha as GeneralizedAlpha,
)
from .simulation import (
    Happening as Happening,
)
from .simulation import (
    LinearModel as LinearModel,
)
from .simulation import (
    LoadPath as LoadPath,
)
from .simulation import (
    MechanismModes as MechanismModes,
)
from .simulation import (
    Newmark as Newmark,
)
from .simulation import (
    PathFailed as PathFailed,
)
from .simulation import (
    RunFailed as RunFailed,
)
from .simulation import (
    RunInterrupted as RunInterrupted,
)
from .simulation import (
    Simulator as Simulator,
)
from .simulation import (
    Solution as Solution,
)
from .simulation import (
    State as State,
)
from .simulation import (
    buckling as buckling,
)
from .simulation import (
    campbell as campbell,
)
from .simulation import (
    equilibrium as equilibrium,
)
from .simulation import (
    inverse_dynamics as inverse_dynamics,
)
from .simulation import (
    kinematics as kinematics,
)
from .simulation import (
    linearise as linearise,
)
from .simulation import (
    load as load,
)
from .simulation import (
    load_path as load_path,
)
from .simulation import (
    modes as modes,
)
from .simulation import (
    settled as settled,
)
from .simulation import (
    simulate as simulate,
)
from .simulation import (
    steady_rotation as steady_rotation,
)

__version__: str
from .output import (
    draw as draw,
)
from .output import (
    plot_cycles as plot_cycles,
)
from .output import (
    plot_damage as plot_damage,
)
from .output import (
    plot_sn as plot_sn,
)
from .output import (
    write_csv as write_csv,
)
from .output import (
    write_damage as write_damage,
)
from .output import (
    write_load_path as write_load_path,
)
from .output import (
    write_mesh as write_mesh,
)
from .parts import (
    FKM as FKM,
)
from .parts import (
    SN as SN,
)
from .parts import (
    SWT as SWT,
)
from .parts import (
    Gerber as Gerber,
)
from .parts import (
    Goodman as Goodman,
)
from .parts import (
    MeanStress as MeanStress,
)
from .parts import (
    Morrow as Morrow,
)
from .parts import (
    PartCompression as PartCompression,
)
from .parts import (
    Soderberg as Soderberg,
)
from .parts import (
    Walker as Walker,
)
from .parts import (
    WeldRatio as WeldRatio,
)
from .parts import (
    estimate_sn as estimate_sn,
)
from .parts import (
    fat_class as fat_class,
)
from .parts import (
    finish_factor as finish_factor,
)
from .parts import (
    load_factor as load_factor,
)
from .parts import (
    reliability_factor as reliability_factor,
)
from .parts import (
    roughness_factor as roughness_factor,
)
from .parts import (
    size_factor as size_factor,
)
from .parts import (
    sn_curve as sn_curve,
)
from .parts import (
    sn_curves as sn_curves,
)
from .parts import (
    thickness_factor as thickness_factor,
)
from .planar import PlanarFrame as PlanarFrame
from .recovery.fatigue import (
    Assessment as Assessment,
)
from .recovery.fatigue import (
    Cycles as Cycles,
)
from .recovery.fatigue import (
    DamageField as DamageField,
)
from .recovery.fatigue import (
    DutyCycle as DutyCycle,
)
from .recovery.fatigue import (
    DutyEvent as DutyEvent,
)
from .recovery.fatigue import (
    RainflowMatrix as RainflowMatrix,
)
from .recovery.fatigue import (
    assess as assess,
)
from .recovery.fatigue import (
    damage as damage,
)
from .recovery.fatigue import (
    damage_field as damage_field,
)
from .recovery.fatigue import (
    life as life,
)
from .recovery.fatigue import (
    rainflow as rainflow,
)
from .recovery.fatigue import (
    site_cycles as site_cycles,
)
from .recovery.fatigue import (
    stress_safety as stress_safety,
)
