"""jousto: flexible multibody dynamics, from finite element model to simulated mechanism.

One noun per stage: ``Part`` -> ``reduce`` -> ``ReducedPart`` -> bodies, joints, forces and sensors
in a ``Mechanism`` -> ``compile`` -> ``Model`` -> ``simulate`` -> ``Solution``. SI units everywhere.

The public names stand in ``__init__.pyi``; each is loaded when it is first used, so that importing
the package is quick.
"""

from typing import Any

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name, or look up the version."""
    if name != "__version__":
        return _load(name)
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("jousto")
    except PackageNotFoundError:  # a source tree that is not installed
        return "unknown"
