"""Stress and strain fields: any place, any instant, in blocks that fit the memory."""

from jousto.recovery.fields.build import field_from, stress_field
from jousto.recovery.fields.criteria import Criterion, Plane, criteria, evaluate, von_mises
from jousto.recovery.fields.field import Envelope, StressField

__all__ = [
    "Criterion",
    "Envelope",
    "Plane",
    "StressField",
    "criteria",
    "evaluate",
    "field_from",
    "stress_field",
    "von_mises",
]
