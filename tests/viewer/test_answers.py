"""Answers to the page: the same numbers as those of the run, and sentences for what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.shape import positions
from jousto.viewer.container import pack, unpack
from jousto.viewer.frames import LARGEST, Frames, nearest, thinned
from jousto.viewer.queries import Answers
from jousto.viewer.viewable import scenes_of
from session import objects
from viewer.machines import HIGH, LENGTH, answers, number_of, swing

# sums of a few products in another order: some units in the last place of the largest term
ROUNDING = 1e-9


def ask(request: dict[str, Any], found: Answers | None = None) -> dict[str, Any]:
    """Return an answer as the page gets it."""
    return unpack(pack((found or answers()).answer({"id": 1} | request)))


# -- scene and frames -----------------------------------------------------------------------


def test_the_scene_says_what_it_is_and_halves_keep_three_digits() -> None:
    header = ask({"ask": "scene"})
    run, scene = swing(), answers().scenes[0]
    assert (header["kind"], header["version"], header["what"]) == ("scene", 1, "run")
    np.testing.assert_array_equal(header["frames"], run.time)
    assert header["window"] == [0.0, run.time[-1]] and header["thinned"] == 1
    body = header["bodies"][number_of("bar")]
    assert body["positions"].dtype == np.float32 and body["triangles"].dtype == np.uint32
    assert body["shapes"].dtype == body["stress"].dtype == np.float16
    exact = scene.bodies[number_of("bar")]
    for name, factors in (("shapes", "shape_scale"), ("stress", "stress_scale")):
        scale = np.array(body[factors])[:, None, None]
        error = np.abs(body[name].astype(float) * scale - getattr(exact, name))
        # half a unit in the 11th digit of the binary fraction of the largest value
        assert np.all(error <= 2.0**-11 * scale)


def test_rows_are_those_of_the_run() -> None:
    run = swing()
    rows = ask({"ask": "rows", "first": 10, "count": 4, "every": 5})
    np.testing.assert_array_equal(rows["time"], run.time[10:30:5])
    np.testing.assert_array_equal(rows["rows"][:, : run.q.shape[1]], run.q[10:30:5].astype("f4"))
    last = ask({"ask": "rows", "first": run.nt - 2, "count": 100, "every": 1})
    assert len(last["time"]) == 2  # as many as there are


def test_a_request_for_10_gb_is_refused_with_how_many_there_may_be() -> None:
    width = len(answers().scenes[0].still)
    most = LARGEST // (4 * width)
    with pytest.raises(InputError, match=f"{most} of them"):
        answers().answer({"id": 1, "ask": "rows", "first": 0, "count": 10**10, "every": 1})
    with pytest.raises(InputError, match="ask for fewer"):
        answers().answer({"id": 1, "ask": "rows", "first": 0, "count": most + 1, "every": 1})


def test_long_runs_are_thinned_and_a_window_has_all_instants() -> None:
    times = np.linspace(0.0, 100.0, 100_001)
    frames = Frames.thinned(0, len(times))
    assert frames.number <= 20_000 and frames.every == 6
    window = Frames.within(times, 10.0, 11.0)
    chosen = times[window.first :: window.every][: window.number]
    assert window.every == 1 and chosen[0] <= 10.0 and chosen[-1] >= 11.0
    assert frames.rows(100, 10, 2, 5) == slice(600, 600 + 9 * 12 + 1, 12)
    assert len(range(*frames.rows(frames.number - 1, 10, 1, 5).indices(len(times)))) == 1


def test_windows_belong_to_their_page() -> None:
    own = Answers(answers().scenes)
    window = ask({"ask": "window", "page": 1, "start": 0.1, "end": 0.2}, own)
    assert window["frames"][0] >= 0.098 and len(window["frames"]) < 60
    rows = ask({"ask": "rows", "page": 1, "first": 0, "count": 1, "every": 1}, own)
    assert rows["time"][0] == window["frames"][0]
    other = ask({"ask": "rows", "page": 2, "first": 0, "count": 1, "every": 1}, own)
    assert other["time"][0] == 0.0
    for start, end, said in ((0.2, 0.1, "end after"), (5.0, 6.0, "outside")):
        with pytest.raises(InputError, match=said):
            own.answer({"id": 1, "ask": "window", "start": start, "end": end})


def test_nearest_and_thinned() -> None:
    times = np.array([0.0, 1.0, 3.0])
    asked = (-5.0, 0.4, 0.6, 1.9, 2.1, 9.0)
    assert [nearest(times, t) for t in asked] == [0, 0, 1, 1, 2, 2]
    assert nearest(np.array([2.0]), 5.0) == 0
    rng = np.random.default_rng(3)
    series = rng.standard_normal((3, 10_007))
    kept = thinned(series, 300)
    assert kept[0] == 0 and kept[-1] == 10_006 and len(kept) <= 302
    np.testing.assert_array_equal(series[:, kept].max(axis=1), series.max(axis=1))
    np.testing.assert_array_equal(series[:, kept].min(axis=1), series.min(axis=1))


# -- points ---------------------------------------------------------------------------------


def test_a_probe_is_the_position_and_stress_of_the_run() -> None:
    run, body = swing(), answers().scenes[0].bodies[number_of("bar")]
    field = jo.stress_field(run, "bar", frame="body")
    k = 117
    where = positions(run, "bar", run.time[k : k + 1])[0]
    for vertex in (0, 40, len(body.positions) - 1):
        found = ask(
            {"ask": "probe", "body": number_of("bar"), "vertex": vertex, "time": run.time[k] + 4e-4}
        )
        node = found["node"] - 1
        assert found["time"] == run.time[k]
        np.testing.assert_allclose(found["position"], where[node], rtol=0, atol=1e-12 * LENGTH)
        site = list(field.modes.nodes).index(node)
        s = field.S[site] @ field.p[k]
        scale = np.abs(field.S[site]) @ np.abs(field.p[k])
        np.testing.assert_allclose(found["stress"], s, rtol=0, atol=1e-12 * scale.max())
        assert found["von-mises"] == pytest.approx(evaluate(s, "von-mises"), rel=ROUNDING)
        assert found["principal"][0] == pytest.approx(evaluate(s, "principal-1"), rel=ROUNDING)
        assert found["damage"] is None and found["life"] is None


def test_a_rigid_body_has_positions_alone() -> None:
    ball = answers().scenes[0].bodies[number_of("ball")]
    found = ask({"ask": "probe", "body": number_of("ball"), "vertex": 0, "time": 0.0})
    assert found["stress"] is None and found["displacement"] == [0.0, 0.0, 0.0]
    x = np.asarray(ball.positions[0])
    np.testing.assert_allclose(found["position"], x + [LENGTH, 0.02, HIGH / 2], atol=1e-9)


def test_a_history_is_that_of_the_field() -> None:
    run = swing()
    body, vertex = answers().scenes[0].bodies[number_of("bar")], 40
    of = ["von-mises", "s11", "displacement", "ux", "x", "damage"]
    found = ask(
        {"ask": "history", "body": number_of("bar"), "vertex": vertex, "of": of, "most": 5000}
    )
    field = jo.stress_field(run, "bar", frame="body")
    site = field.labels[list(field.modes.nodes).index(int(body.nodes[vertex]) - 1)]
    np.testing.assert_array_equal(found["time"], run.time)
    top = np.abs(field.values("s11")).max()
    for row, name in enumerate(of[:2]):
        exact = field.only(site).values(name)[:, 0]
        np.testing.assert_allclose(found["values"][row], exact, rtol=0, atol=ROUNDING * top)
    where = positions(run, "bar")[:, int(body.nodes[vertex]) - 1, 0]
    np.testing.assert_allclose(found["values"][4], where, rtol=0, atol=1e-12)
    assert found["units"] == ["Pa", "Pa", "m", "m", "m", "1"] and found["labels"] == of
    assert np.isnan(found["values"][5]).all()
    short = ask(
        {"ask": "history", "body": number_of("bar"), "vertex": vertex, "of": ["s11"], "most": 40}
    )
    assert len(short["time"]) <= 42
    assert short["values"].max() == found["values"][1].max()


def test_sensors_have_a_curve_for_each_component() -> None:
    run = swing()
    found = ask({"ask": "sensor", "names": ["ball", "pin"], "most": 5000})
    assert found["labels"][:3] == ["ball x", "ball y", "ball z"] and len(found["units"]) == 9
    assert found["units"][0] == "m" and found["units"][-1] == "N m"
    np.testing.assert_array_equal(found["values"][:3], run["ball"].T)


def test_a_swept_beam_is_where_its_picture_is() -> None:
    from jousto.recovery.fields.criteria import evaluate
    from jousto.scene.values_at_rows import rows_at, stresses, vertices

    run = objects()["beam run"]
    own = Answers(scenes_of([run]))
    (k,) = (k for k, body in enumerate(own.scenes[0].bodies) if body.rings is not None)
    beam = own.scenes[0].bodies[k]
    i = run.nt // 2
    row = rows_at(own.scenes[0], run.time[i : i + 1])
    x, mises = vertices(beam, row)[0], evaluate(stresses(beam, row), "von-mises")[0]
    size = np.ptp(x, axis=0).max()
    for vertex in (0, 7, len(beam.positions) // 2, len(beam.positions) - 1):
        found = ask({"ask": "probe", "body": k, "vertex": vertex, "time": run.time[i]}, own)
        away = np.linalg.norm(x - found["position"], axis=1)
        assert away.min() < 1e-9 * size
        exact = mises[away < 1e-9 * size]
        assert np.abs(exact - found["von-mises"]).min() <= 1e-9 * mises.max()


# -- over the run ---------------------------------------------------------------------------


@pytest.mark.parametrize("measure", ["von-mises", "principal-max", "principal-min", "s11", "s12"])
def test_ranges_and_worst_places_are_those_of_the_whole_run(measure: str) -> None:
    values = jo.stress_field(swing(), "bar", frame="body").values(
        {"principal-max": "principal-1", "principal-min": "principal-3"}.get(measure, measure)
    )
    extent = ask({"ask": "extent", "measure": measure})
    top = np.abs(values).max()
    low = 0.0 if measure == "von-mises" else values.min()
    np.testing.assert_allclose(
        [extent["low"], extent["high"]], [low, values.max()], atol=1e-9 * top
    )
    worst = ask({"ask": "worst", "measure": measure, "count": 3})["worst"]
    by = np.abs(values) if measure in ("s11", "s12") else values
    by = -values if measure == "principal-min" else by
    k, _ = np.unravel_index(by.argmax(), by.shape)
    assert worst[0]["time"] == swing().time[k]
    assert abs(worst[0]["value"]) == pytest.approx(by.max(), rel=ROUNDING)
    probe = ask({"ask": "probe", **{x: worst[0][x] for x in ("body", "vertex", "time")}})
    np.testing.assert_allclose(probe["position"], worst[0]["position"], atol=1e-12)
    if measure == "von-mises":
        assert probe["von-mises"] == pytest.approx(worst[0]["value"], rel=ROUNDING)
        x = np.array([spot["position"] for spot in worst])
        assert np.linalg.norm(x[1:] - x[0], axis=1).min() > 0.02  # not one place three times


def test_the_largest_displacement() -> None:
    run = swing()
    body = answers().scenes[0].bodies[number_of("bar")]
    u = np.einsum("tj,jvi->tvi", run.coordinates("bar")[:, 7:], body.shapes)
    worst = ask({"ask": "worst", "measure": "displacement", "count": 1})["worst"][0]
    # of more than 200 instants one in some is looked at
    assert worst["value"] == pytest.approx(np.linalg.norm(u, axis=2).max(), rel=0.02)
    assert ask({"ask": "extent", "measure": "displacement"})["high"] == worst["value"]


def test_damage_is_shown_where_it_is() -> None:
    field = jo.damage_field(
        jo.stress_field(swing(), "bar"), jo.fatigue.fat_class(71), residue="half"
    )
    own = Answers(scenes_of([swing()], damage=field))
    assert {"damage"} <= set(own.scenes[0].measures)
    worst = ask({"ask": "worst", "measure": "damage", "count": 2}, own)["worst"]
    assert worst[0]["value"] == pytest.approx(float(field.damage.max()), rel=1e-12)
    probe = ask(
        {"ask": "probe", "body": worst[0]["body"], "vertex": worst[0]["vertex"], "time": 0.0}, own
    )
    assert probe["damage"] == worst[0]["value"]
    # the largest damage lives shortest: T D_allowed / D
    assert probe["life"] == pytest.approx(0.5 * field.allowable / probe["damage"], rel=1e-12)
    high = ask({"ask": "extent", "measure": "damage"}, own)["high"]
    assert high == pytest.approx(worst[0]["value"], rel=1e-9)  # of equal ones another comes first


# -- what is wrong --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ({}, "asks for ''"),
        ({"ask": "files"}, "asks for 'files'; there are scene"),
        ({"ask": 5}, "ask is 5, must be a text"),
        ({"ask": "scene", "run": 1}, "run is 1, must be a whole number from 0 to 0"),
        ({"ask": "scene", "run": True}, "run is True"),
        ({"ask": "rows"}, "first is None"),
        ({"ask": "rows", "first": -1, "count": 1, "every": 1}, "first is -1"),
        ({"ask": "rows", "first": 10**30, "count": 1, "every": 1}, "first is 1000000"),
        ({"ask": "rows", "first": 0, "count": 1, "every": 0}, "every is 0"),
        ({"ask": "rows", "first": 0, "count": "5", "every": 1}, "count is '5'"),
        ({"ask": "probe", "body": 99, "vertex": 0, "time": 0}, "body is 99"),
        ({"ask": "probe", "body": 0, "vertex": 10**9, "time": 0}, "vertex is 1000000000"),
        ({"ask": "probe", "body": 0, "vertex": 0, "time": "x"}, "time is 'x', must be a number"),
        ({"ask": "probe", "body": 0, "vertex": 0, "time": 10**400}, "must be a number"),
        ({"ask": "probe", "body": [0], "vertex": 0, "time": 0}, "body is \\[0\\]"),
        ({"ask": "history", "body": 0, "vertex": 0, "of": []}, "a list of 1 to 64 texts"),
        ({"ask": "history", "body": 0, "vertex": 0, "of": ["mises"]}, "there is no 'mises'"),
        ({"ask": "history", "body": 0, "vertex": 0, "of": "s11"}, "of is 's11'"),
        ({"ask": "history", "body": 0, "vertex": 0, "of": ["x"], "most": 1}, "most is 1"),
        ({"ask": "sensor", "names": ["bal"]}, "no sensor 'bal'; did you mean 'ball'"),
        ({"ask": "sensor", "names": [5]}, "a list"),
        ({"ask": "worst", "measure": "von-mises", "count": 10**6}, "count is 1000000"),
        ({"ask": "worst", "measure": "mises"}, "measure is 'mises'"),
        ({"ask": "extent", "measure": None}, "measure is None"),
        ({"ask": "window", "start": 0, "end": None}, "end is None"),
    ],
)
def test_what_is_wrong_is_a_sentence(request_: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        answers().answer({"id": 1} | request_)
