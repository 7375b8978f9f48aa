"""TWIN: what strain gauges tell of the whole body: stress everywhere, loads and life."""

from jousto.recovery.twin.bands import Band, stress_band, stress_blocks
from jousto.recovery.twin.life import DamageBand, damage_band
from jousto.recovery.twin.loads import (
    FourierLoads,
    equivalent_load,
    external,
    identify_fourier,
    identify_loads,
    identify_payload,
    locate_load,
    place_loads,
)
from jousto.recovery.twin.observed import Observed, Step
from jousto.recovery.twin.observer import Balance, Observer
from jousto.recovery.twin.placement import Placement, place_gauges
from jousto.recovery.twin.posterior import Posterior
from jousto.recovery.twin.reconstruction import Estimate, Reconstruction
from jousto.recovery.twin.reference import InertialForce, Reference
from jousto.recovery.twin.smoother import Histories, draw, smooth
from jousto.recovery.twin.system import Accelerometer, UnknownLoad
from jousto.recovery.twin.tolerance import gauge_errors
from jousto.recovery.twin.tuning import InnovationTest, innovation_test, tune

__all__ = [
    "Accelerometer",
    "Balance",
    "Band",
    "DamageBand",
    "Estimate",
    "FourierLoads",
    "Histories",
    "InertialForce",
    "InnovationTest",
    "Observed",
    "Observer",
    "Placement",
    "Posterior",
    "Reconstruction",
    "Reference",
    "Step",
    "UnknownLoad",
    "damage_band",
    "draw",
    "equivalent_load",
    "external",
    "gauge_errors",
    "identify_fourier",
    "identify_loads",
    "identify_payload",
    "innovation_test",
    "locate_load",
    "place_gauges",
    "place_loads",
    "smooth",
    "stress_band",
    "stress_blocks",
    "tune",
]
