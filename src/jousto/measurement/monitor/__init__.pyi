# names of jo.monitor; they are loaded from here when they are first used
from .alarms import AlarmLimits as AlarmLimits
from .health import ChannelRules as ChannelRules
from .monitor import Monitor as Monitor
from .record_reader import MonitorRecord as MonitorRecord
from .setup import MonitorSettings as MonitorSettings
from .watch import watch as watch
