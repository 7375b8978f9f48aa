"""Fatigue: cycles, damage and life of stress histories."""

from jousto.recovery.fatigue.damage import Assessment, assess, damage, life, stress_safety
from jousto.recovery.fatigue.duty import DutyCycle, DutyEvent
from jousto.recovery.fatigue.field import DamageField, damage_field, site_cycles
from jousto.recovery.fatigue.rainflow import Cycles, RainflowMatrix, rainflow

__all__ = [
    "Assessment",
    "Cycles",
    "DamageField",
    "DutyCycle",
    "DutyEvent",
    "RainflowMatrix",
    "assess",
    "damage",
    "damage_field",
    "life",
    "rainflow",
    "site_cycles",
    "stress_safety",
]
