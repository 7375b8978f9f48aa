# names of jo.twin; they are loaded from here when they are first used
from .bands.bands import Band as Band, stress_band as stress_band, stress_blocks as stress_blocks
from .bands.life import DamageBand as DamageBand, damage_band as damage_band
from .estimates import Estimates as Estimates, Posterior as Posterior
from .kalman import Balance as Balance
from .loads import (
    FourierLoads as FourierLoads,
    equivalent_load as equivalent_load,
    external as external,
    identify_fourier as identify_fourier,
    identify_loads as identify_loads,
    identify_payload as identify_payload,
    locate_load as locate_load,
    place_loads as place_loads,
)
from .mode_weights import WeighedModes as WeighedModes, weigh_modes as weigh_modes
from .motion.part_motion import drive_part as drive_part
from .motion.reference import InertialForce as InertialForce, Reference as Reference
from .motion.system import Accelerometer as Accelerometer, UnknownLoad as UnknownLoad
from .observer import Observer as Observer
from .placement import Placement as Placement, place_gauges as place_gauges
from .reconstruction import Estimate as Estimate, Reconstruction as Reconstruction
from .signals import gauge_errors as gauge_errors
from .smoother import Histories as Histories, sample_posterior as sample_posterior, smooth as smooth
from .tuning import (
    InnovationTest as InnovationTest,
    innovation_test as innovation_test,
    tune as tune,
)
