"""All kinds of signals, in the order of their documentation."""

from jousto.mechanism.signals.base import (
    Constant,
    ConstantSpeed,
    Input,
    Product,
    Signal,
    Sum,
)
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Ramp, SCurve, Step, Table
from jousto.mechanism.signals.switched import Switched

SIGNALS: tuple[type[Signal], ...] = (
    Harmonic,
    Table,
    Step,
    Constant,
    ConstantSpeed,
    Ramp,
    SCurve,
    Input,
    Switched,
    Sum,
    Product,
)
