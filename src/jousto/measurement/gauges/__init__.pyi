# names of jo.gauges; they are loaded from here when they are first used
from ...mechanism.sensors.bridge import (
    Bridge as Bridge,
    bridge_output as bridge_output,
    quarter_bridge_strain as quarter_bridge_strain,
)
from ...mechanism.sensors.gauge import Gauge as Gauge, gauge_rows as gauge_rows
from ...mechanism.sensors.rosette import Rosette as Rosette
from ...mechanism.sensors.temperature import Temperature as Temperature
from .align import Alignment as Alignment, align as align
from .compare import (
    GaugeComparison as GaugeComparison,
    GaugePair as GaugePair,
    compare_gauges as compare_gauges,
)
from .read import read_record as read_record
from .record import Record as Record, record_of as record_of
from .rosettes import RosetteState as RosetteState, rosette_state as rosette_state
