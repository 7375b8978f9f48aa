# names of jo.model; they are loaded from here when they are first used
from .native.damage_meter import DamageMeter as DamageMeter
from .native.distance import shape_distance as shape_distance
from .native.native import Engine as Engine
from .variants import Variants as Variants
