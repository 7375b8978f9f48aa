# the public names; __init__.py loads them from here when they are first used
from .engine import Engine as Engine, Model as Model, compile as compile
from .errors import (
    InputError as InputError,
    JoustoError as JoustoError,
    JoustoWarning as JoustoWarning,
    Problem as Problem,
    SimulationError as SimulationError,
)
from .mechanism import (
    AngularVelocitySensor as AngularVelocitySensor,
    Fixed as Fixed,
    FlexibleBody as FlexibleBody,
    Force as Force,
    Gravity as Gravity,
    Harmonic as Harmonic,
    Mechanism as Mechanism,
    ModalSensor as ModalSensor,
    OrientationSensor as OrientationSensor,
    PositionSensor as PositionSensor,
    ReactionSensor as ReactionSensor,
    Revolute as Revolute,
    RigidBody as RigidBody,
    Rotate as Rotate,
    Spherical as Spherical,
    Step as Step,
    StressSensor as StressSensor,
    Table as Table,
    Torque as Torque,
    VelocitySensor as VelocitySensor,
    ground as ground,
)
from .output import animate as animate, plot as plot, still as still
from .parts import (
    Box as Box,
    Circle as Circle,
    EulerBernoulli as EulerBernoulli,
    GeneralSection as GeneralSection,
    IBeam as IBeam,
    Material as Material,
    Member as Member,
    Part as Part,
    PointMass as PointMass,
    Rectangle as Rectangle,
    SectionPoint as SectionPoint,
    Timoshenko as Timoshenko,
    Tube as Tube,
)
from .reduction import (
    CraigBampton as CraigBampton,
    FreeFree as FreeFree,
    Rayleigh as Rayleigh,
    ReducedPart as ReducedPart,
    reduce as reduce,
)
from .schema import read_model as read_model
from .simulation import (
    RK4 as RK4,
    ROS2 as ROS2,
    Baumgarte as Baumgarte,
    RunFailed as RunFailed,
    RunInterrupted as RunInterrupted,
    Solution as Solution,
    load as load,
    simulate as simulate,
)

__version__: str
