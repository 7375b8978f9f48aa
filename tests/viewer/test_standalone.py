"""Pages in one file: the instants they keep, and the work of making them."""

from __future__ import annotations

import cProfile
import functools
import pstats
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.recovery.hotspots import hot_spots
from jousto.viewer.extremes import stress_fields
from jousto.viewer.frames import Frames
from jousto.viewer.standalone import contents, page
from jousto.viewer.viewable import scenes_of
from viewer.machines import number_of, swing


def test_the_instants_of_the_worst_places_are_in_a_thinned_page() -> None:
    """A place shows the value that it has in the list: float32 rows keep 7 digits of it."""
    run = swing()
    scene = scenes_of([run])[0]
    kept = contents(scene, 10)
    assert len(kept["time"]) < run.nt and np.all(np.diff(kept["time"]) > 0.0)
    np.testing.assert_array_equal(kept["scene"]["frames"], kept["time"])
    evenly = run.time[Frames.thinned(0, run.nt, most=10).rows_of_all()]
    assert set(evenly) <= set(kept["time"])
    for place in kept["worst"]["von-mises"]:
        row = int(np.flatnonzero(kept["time"] == place["time"])[0])
        assert place["body"] == number_of("bar")
        instant = int(np.flatnonzero(run.time == place["time"])[0])
        width = run.q.shape[1]
        np.testing.assert_array_equal(kept["rows"][row, :width], run.q[instant].astype("f4"))


@functools.cache
def link() -> jo.ReducedPart:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    beam = jo.Part.beam(1.0, jo.Rectangle(0.008, 0.04), 4, steel)
    return jo.reduce(beam, jo.CraigBampton(("start", "end"), modes=1))


def chain(count: int, path: Path) -> jo.Solution:
    """Return the results, in a file, of a chain of elastic links."""
    items, end = [], jo.ground["origin"]
    for i in range(count):
        body = jo.FlexibleBody(f"link{i}", link(), position=(float(i), 0.0, 0.0))
        items += [body, jo.Revolute(f"pin{i}", end, body["start"], axis=(0, 1, 0))]
        end = body["end"]
    model = jo.compile(jo.Mechanism(*items, jo.Gravity((0, 0, -9.81))))
    jo.simulate(model, 4e-3, solver=jo.ROS2(1e-3), path=path)
    return jo.load(path)


def opened(run: jo.Solution) -> int:
    """Return how many pieces of the results file are read for a page."""
    profile = cProfile.Profile()
    profile.runcall(page, scenes_of([run]))
    stats = pstats.Stats(profile).stats
    return sum(v[1] for k, v in stats.items() if k[0].endswith("h5py/_hl/group.py"))


def test_the_pieces_read_for_a_page_grow_with_the_bodies(tmp_path: Path) -> None:
    """Each body is read a few times: 2 for linear work, 4 where each reads all of them.

    What is read once is in neither difference.
    """
    chain(2, tmp_path / "warm.h5")
    opened(jo.load(tmp_path / "warm.h5"))  # loads modules
    one, two, four = (opened(chain(n, tmp_path / f"{n}.h5")) for n in (4, 8, 16))
    assert (four - two) / (two - one) < 2.1


def test_a_body_is_found_alone_in_memory_and_in_files(tmp_path: Path) -> None:
    run = chain(3, tmp_path / "run.h5")
    for found in (run, swing()):
        for body in found.bodies:
            alone = found.body(body.name)
            assert alone is not None and alone.q_offset == body.q_offset
            np.testing.assert_array_equal(alone.nodes, body.nodes)
        assert found.body("nobody") is None


def test_only_bodies_that_may_have_a_worst_place_are_searched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The places are those of `hot_spots`, which searches all; the work does not grow with bodies.

    The chain lies level when it is let go and hangs from one end, where it is bent most: ten
    places lie on its first links, however many follow. Stress across the links is 0 everywhere.
    """
    searched: list[int] = []
    whole = hot_spots.search

    def counted(modes: np.ndarray, *given: Any, **named: Any) -> Any:
        searched.append(len(modes))
        return whole(modes, *given, **named)

    monkeypatch.setattr(hot_spots, "search", counted)
    work = {}
    for n in (4, 8):
        fields = stress_fields(scenes_of([chain(n, tmp_path / f"{n}.h5")])[0])
        for criterion in ("von-mises", "principal-1", "principal-3", "s11", "s13"):
            searched.clear()
            found = hot_spots.worst_places(fields, count=10, criterion=criterion, separation=0.04)
            work[n, criterion] = len(searched)
            full = hot_spots.hot_spots(fields, criterion=criterion, separation=0.04)
            told = [(x.body, x.site, x.time, x.value) for x in full.spots]
            assert [(x.body, x.site, x.time, x.value) for x in found] == told
            assert work[n, criterion] == work[4, criterion] < 4
