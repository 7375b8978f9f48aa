"""Gauges: what rosettes say, and measured records."""

from jousto.recovery.gauges.align import Alignment
from jousto.recovery.gauges.compare import GaugeComparison, GaugePair, compare_gauges
from jousto.recovery.gauges.read import read_record
from jousto.recovery.gauges.record import Record, record_of
from jousto.recovery.gauges.rosettes import RosetteState, rosette_state

__all__ = [
    "Alignment",
    "GaugeComparison",
    "GaugePair",
    "Record",
    "RosetteState",
    "compare_gauges",
    "read_record",
    "record_of",
    "rosette_state",
]
