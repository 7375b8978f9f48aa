"""RECOVER: fields over a body from the few coordinates that a run stores."""

from jousto.recovery.beams import RESULTANTS, SectionForces, section_forces
from jousto.recovery.budget import ErrorBudget, error_budget
from jousto.recovery.fields import (
    Criterion,
    Envelope,
    Plane,
    StressField,
    criteria,
    evaluate,
    field_from,
    stress_field,
    von_mises,
)
from jousto.recovery.friction import (
    FrictionStress,
    Transition,
    friction_stress,
    without_friction,
)
from jousto.recovery.gauges import (
    Alignment,
    GaugeComparison,
    GaugePair,
    Record,
    RosetteState,
    compare_gauges,
    read_record,
    record_of,
    rosette_state,
)
from jousto.recovery.hotspots import HotSpot, HotSpots, hot_spots
from jousto.recovery.shape import bracket, find_body, positions, rotation_matrices
from jousto.recovery.stress import Peak, peak, stress, surface_stress

__all__ = [
    "bracket",
    "RESULTANTS",
    "SectionForces",
    "section_forces",
    "Alignment",
    "GaugeComparison",
    "GaugePair",
    "Record",
    "RosetteState",
    "compare_gauges",
    "read_record",
    "record_of",
    "rosette_state",
    "Criterion",
    "Envelope",
    "ErrorBudget",
    "HotSpot",
    "HotSpots",
    "FrictionStress",
    "Peak",
    "Plane",
    "StressField",
    "Transition",
    "criteria",
    "error_budget",
    "evaluate",
    "field_from",
    "find_body",
    "hot_spots",
    "friction_stress",
    "peak",
    "positions",
    "rotation_matrices",
    "stress",
    "stress_field",
    "surface_stress",
    "von_mises",
    "without_friction",
]
