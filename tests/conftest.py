"""Settings that every test shares."""

from __future__ import annotations

import atexit
import importlib
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Iterator
from hashlib import sha256
from typing import Any

import matplotlib
import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from jousto.base.errors import InputError

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
settings.register_profile("few", settings.get_profile("ci"), max_examples=10)
settings.load_profile(
    os.environ.get("HYPOTHESIS_PROFILE") or ("ci" if os.environ.get("CI") else "default")
)


END = pytest.StashKey[float]()  # instant after which no test begins, s of time.monotonic

CHOOSING = (  # examples that say which core compile chose
    "jousto.certificate.doctor.doctor",
    "test_code_of_the_page_runs[docs/robots.md]",
    "test_code_of_the_page_runs[docs/joint-coordinates.md]",
)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--core",
        choices=["auto", "joint", "maximal"],
        default="auto",
        help="what runs models for which a test names no core: what compile chooses (auto), joint "
        "coordinates wherever a model can, or the positions of the bodies",
    )
    parser.addoption(
        "--minutes",
        type=float,
        default=np.inf,
        help="begin no test after this time: what is left is skipped, and reported so",
    )
    parser.addoption(
        "--shuffle",
        default="",
        metavar="WORD",
        help="files in an order that depends on this word, so that runs of a few minutes differ",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Force a core on all that tests compile in this process, without touching the product."""
    config.stash[END] = time.monotonic() + 60 * config.getoption("--minutes")
    if (forced := config.getoption("--core")) == "auto":
        return
    compiling = importlib.import_module("jousto.model.compile")
    choose = compiling.with_core

    def forcing(model: Any, core: str) -> Any:
        if core != "auto":
            return choose(model, core)
        try:
            return choose(model, forced)
        except InputError:
            return choose(model, "maximal")

    compiling.with_core = forcing  # type: ignore[attr-defined]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with what takes long; leave out what tests the choice of a core where none is left."""
    # examples and pages, up to half a minute each: at the end one process would wait for the other
    items.sort(key=lambda item: item.path.parent != config.rootpath / "tests")
    if word := config.getoption("--shuffle"):
        items.sort(key=lambda item: sha256(f"{word} {item.path.name}".encode()).digest())
    if (forced := config.getoption("--core")) == "auto":
        return
    for item in items:
        if item.get_closest_marker("chooses") or item.name in CHOOSING:
            item.add_marker(
                pytest.mark.skip(reason=f"about what auto chooses, not --core {forced}")
            )


@pytest.hookimpl(tryfirst=True)  # before the fixtures of the test
def pytest_runtest_setup(item: pytest.Item) -> None:
    if time.monotonic() > item.config.stash[END]:
        pytest.skip("the minutes given are over")


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Name a failed test at once: a run that is stopped half-way tells what it has found."""
    if report.failed and "PYTEST_XDIST_WORKER" not in os.environ:
        crash = getattr(report.longrepr, "reprcrash", None)
        what = str(crash.message if crash else report.longrepr).strip().splitlines()
        print(f"\nfailed: {report.nodeid}: {' '.join(what[:3])[:400]}", flush=True)


@pytest.fixture
def rng() -> np.random.Generator:
    """The same random numbers in every run."""
    return np.random.default_rng(20070607)


@pytest.fixture(params=["SIG_IGN", "SIG_DFL"])
def broken_pipe(request: pytest.FixtureRequest) -> Iterator[None]:
    """SIGPIPE as Python has it, and as Gmsh leaves it: then a broken pipe ends the program."""
    pipe = getattr(signal, "SIGPIPE", None)
    before = signal.signal(pipe, getattr(signal, request.param)) if pipe else None
    yield
    if pipe:
        assert signal.getsignal(pipe) == getattr(signal, request.param)
        signal.signal(pipe, before)
