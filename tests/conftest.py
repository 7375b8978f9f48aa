"""Settings that every test shares."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile

import matplotlib
import numpy as np
import pytest
from hypothesis import HealthCheck, settings

matplotlib.use("Agg")

# large reductions are kept for the next time, but not from one run of the tests to the next
if "JOUSTO_CACHE" not in os.environ:
    os.environ["JOUSTO_CACHE"] = tempfile.mkdtemp(prefix="jousto-cache-")
    atexit.register(shutil.rmtree, os.environ["JOUSTO_CACHE"], ignore_errors=True)

# on a build machine property tests must neither depend on luck nor on the clock
settings.register_profile(
    "default", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.register_profile("ci", settings.get_profile("default"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "default")


@pytest.fixture
def rng() -> np.random.Generator:
    """The same random numbers in every run."""
    return np.random.default_rng(20070607)
