# public names of jousto.electric; each is loaded when it is first used
from .brake import Brake as Brake
from .dc_motor import DCMotor as DCMotor
from .gearbox import Gearbox as Gearbox
from .synchronous_motor import SynchronousMotor as SynchronousMotor
from .thermal_load import ThermalLoad as ThermalLoad
