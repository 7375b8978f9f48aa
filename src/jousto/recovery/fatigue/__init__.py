"""Fatigue: cycles, damage and life of stress histories."""

from jousto.recovery.fatigue.damage import Assessment, assess, damage, life, stress_safety
from jousto.recovery.fatigue.rainflow import Cycles, RainflowMatrix, rainflow

__all__ = [
    "Assessment",
    "Cycles",
    "RainflowMatrix",
    "assess",
    "damage",
    "life",
    "rainflow",
    "stress_safety",
]
