# public names of jousto.hydraulics; each is loaded when it is first used
from .accumulator import Accumulator as Accumulator
from .cylinder import Cushion as Cushion, HydraulicCylinder as HydraulicCylinder
from .directional_valve import DirectionalValve as DirectionalValve
from .hose import Hose as Hose
from .logic_valves import (
    FlowControlValve as FlowControlValve,
    PilotCheckValve as PilotCheckValve,
    ReducingValve as ReducingValve,
    SequenceValve as SequenceValve,
    ShuttleValve as ShuttleValve,
)
from .network import HydraulicNetwork as HydraulicNetwork
from .nodes import FlowSource as FlowSource, Node as Node, Supply as Supply, Tank as Tank
from .oil import Oil as Oil
from .orifice import Leak as Leak, Orifice as Orifice
from .pressure_valves import (
    CheckValve as CheckValve,
    CounterbalanceValve as CounterbalanceValve,
    ReliefValve as ReliefValve,
)
from .pump import (
    EfficiencyMap as EfficiencyMap,
    HydraulicMotor as HydraulicMotor,
    Pump as Pump,
)
