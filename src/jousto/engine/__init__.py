"""COMPILE: a mechanism becomes flat arrays for the C engine."""

from jousto.engine.beam_shape import BeamShape
from jousto.engine.compile import compile
from jousto.engine.doctor import Diagnosis, doctor
from jousto.engine.meter import DamageMeter
from jousto.engine.model import Model
from jousto.engine.native import Engine

__all__ = ["BeamShape", "DamageMeter", "Diagnosis", "Engine", "Model", "compile", "doctor"]
