"""jousto: flexible multibody dynamics, from finite element model to simulated mechanism.

The stages of a computation: ``Part`` -> ``reduce`` -> ``ReducedPart`` -> bodies, joints, forces and
sensors in a ``Mechanism`` -> ``compile`` -> ``Model`` -> ``simulate`` -> ``Solution``. SI units
everywhere.

Names for a first model are in the package itself; others are in subpackages such as
``jousto.fatigue``, ``jousto.gauges`` and ``jousto.simulation``. All names are listed in files
``__init__.pyi`` and loaded at first use, so that importing the package is fast.
"""

import sys
from importlib import import_module

from jousto.base.lazy_exports import open_room, public_names

VERBS = ("plot", "write")


def _gone(name: str) -> str:
    """Return the new name of a public name that is no longer in the package itself."""
    if name.startswith("_"):
        return ""
    verb = name.partition("_")[0]
    places = [f"jo.{verb}(...)"] if verb in VERBS else []
    places += (place for place in public_names() if place.endswith(f".{name}"))
    return places[0] if places else ""


open_room(__name__, _gone)

if "IPython" in sys.modules:  # register HTML output of objects in notebook cells
    import_module("jousto.viewer.notebook").register()
