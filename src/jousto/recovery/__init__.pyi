# names of jo.recovery; they are loaded from here when they are first used
from .beams.forces import SectionForces as SectionForces, section_forces as section_forces
from .budget import ErrorBudget as ErrorBudget, error_budget as error_budget
from .fields.build import field_from as field_from
from .fields.criteria import Plane as Plane
from .fields.field import Envelope as Envelope, StressField as StressField
from .friction import (
    FrictionStress as FrictionStress,
    friction_stress as friction_stress,
    without_friction as without_friction,
)
from .hotspots.hot_spots import HotSpots as HotSpots
from .hotspots.search_result import HotSpot as HotSpot
from .loads.body_loads import BodyLoad as BodyLoad, BodyLoads as BodyLoads, BodyMotion as BodyMotion
from .loads.gathered_loads import loads_of as loads_of
