# names of jo.materials; they are loaded from here when they are first used
from .library import names as names
from .orthotropic import Orthotropic as Orthotropic
