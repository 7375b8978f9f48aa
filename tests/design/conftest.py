"""What tests of design share."""

from __future__ import annotations

import warnings
from typing import Any

import pytest


@pytest.fixture(scope="session")
def openturns() -> Any:
    """OpenTURNS, whose import warns of its own wrappers on newer Pythons."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("openturns")
