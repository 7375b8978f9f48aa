"""jousto: flexible multibody dynamics, from finite element model to simulated mechanism.

One noun per stage: ``Part`` -> ``reduce`` -> ``ReducedPart`` -> bodies, joints, forces and sensors
in a ``Mechanism`` -> ``compile`` -> ``Model`` -> ``simulate`` -> ``Solution``. SI units everywhere.

What a first model needs are names of the package itself; more is in its rooms, such as
``jousto.fatigue``, ``jousto.gauges`` and ``jousto.simulation``. All of them stand in files
``__init__.pyi`` and are loaded when they are first used, so that importing the package is quick.
"""

import sys
from importlib import import_module

from jousto.base.lazy_exports import open_room, public_names

VERBS = ("plot", "write")


def _gone(name: str) -> str:
    """Return how a name that was one of the package itself is written now."""
    if name.startswith("_"):
        return ""
    verb = name.partition("_")[0]
    places = [f"jo.{verb}(...)"] if verb in VERBS else []
    places += (place for place in public_names() if place.endswith(f".{name}"))
    return places[0] if places else ""


open_room(__name__, _gone)

if "IPython" in sys.modules:  # its cells show tables and pictures
    import_module("jousto.viewer.notebook").register()
