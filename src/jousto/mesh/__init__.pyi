# names of jo.mesh; they are loaded from here when they are first used
from .cells import Cells as Cells
from .holes import Hole as Hole
from .inspection import Finding as Finding
from .picks import (
    InBox as InBox,
    InCylinder as InCylinder,
    InSphere as InSphere,
    Nearest as Nearest,
    OnPlane as OnPlane,
)
from .quality import Quality as Quality
