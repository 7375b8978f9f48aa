# names of jo.model; they are loaded from here when they are first used
from .native.meter import DamageMeter as DamageMeter
from .native.native import Engine as Engine
from .rank.doctor import Diagnosis as Diagnosis
