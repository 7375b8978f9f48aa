"""Monitoring: measured strains to stress, damage and remaining life while they come."""

from jousto.recovery.monitor.alarms import Alarm, AlarmLimits
from jousto.recovery.monitor.health import STATES, ChannelRules, Health
from jousto.recovery.monitor.life import Life
from jousto.recovery.monitor.monitor import Monitor, Summary, Update
from jousto.recovery.monitor.recorded import Event, MonitorRecord
from jousto.recovery.monitor.setup import MonitorSettings
from jousto.recovery.monitor.stream import Stream
from jousto.recovery.monitor.watch import Progress, watch

__all__ = [
    "STATES",
    "Alarm",
    "AlarmLimits",
    "ChannelRules",
    "Event",
    "Health",
    "Life",
    "Monitor",
    "MonitorRecord",
    "MonitorSettings",
    "Progress",
    "Stream",
    "Summary",
    "Update",
    "watch",
]
