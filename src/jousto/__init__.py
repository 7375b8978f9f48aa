"""jousto: flexible multibody dynamics, from finite element model to simulated mechanism.

One noun per stage: ``Part`` -> ``reduce`` -> ``ReducedPart`` -> bodies, joints, forces and sensors
in a ``Mechanism`` -> ``compile`` -> ``Model`` -> ``simulate`` -> ``Solution``. SI units everywhere.

The public names stand in ``__init__.pyi``; each is loaded when it is first used, so that importing
the package is quick.
"""

from importlib.metadata import PackageNotFoundError, version

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

try:
    __version__ = version("jousto")
except PackageNotFoundError:  # a source tree that is not installed
    __version__ = "unknown"
