"""Signals of time: factors on forces, motions of drives, references of servos, inputs."""

from jousto.mechanism.signals.base import (
    Constant,
    ConstantSpeed,
    Input,
    Product,
    Signal,
    Sum,
    check_factor,
    check_signal,
    leaves,
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

__all__ = [
    "SIGNALS",
    "Constant",
    "ConstantSpeed",
    "Harmonic",
    "Input",
    "Product",
    "Ramp",
    "SCurve",
    "Signal",
    "Step",
    "Sum",
    "Switched",
    "Table",
    "check_factor",
    "check_signal",
    "leaves",
]
