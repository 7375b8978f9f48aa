"""TWIN: what strain gauges tell of the whole body: stress everywhere, loads and life."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
