"""plot: what is drawn, named and refused."""

from __future__ import annotations

import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from PIL import Image

import jousto as jo
from jousto.output.figures.histories import STEPS, envelope, spread, thin
from jousto.output.style import COLORS, DASHES
from jousto.simulation.results.dataframes import pick
from output.runs import swing


def test_a_sensor_is_one_panel_with_unit_and_names() -> None:
    figure = jo.plot(swing(), "tip")
    (ax,) = figure.axes
    assert ax.get_ylabel() == "m"
    assert ax.get_xlabel() == "time (s)"
    assert ax.get_title(loc="left") == "tip"
    texts = [text.get_text() for text in ax.texts]
    assert texts == ["position of hand.center, world frame", "x", "y", "z"]
    for k, line in enumerate(ax.get_lines()):
        np.testing.assert_array_equal(line.get_xdata(), swing().time)
        np.testing.assert_array_equal(line.get_ydata(), swing()["tip"][:, k])


@pytest.mark.parametrize(
    ("name", "sensor", "components"),
    [
        ("tip", "tip", ["x", "y", "z"]),
        ("tip.y", "tip", ["y"]),
        ("tip:z", "tip", ["z"]),
        ("tip.speed", "tip.speed", ["x", "y", "z"]),  # a name with a dot is a name first
        ("tip.speed.x", "tip.speed", ["x"]),
        ("modes.p2'", "modes", ["p2'"]),
        ("stress.e1.a.top:s11", "stress", ["e1.a.top:s11"]),
        ("stress:e1.a.top", "stress", [f"e1.a.top:s{s}" for s in (11, 22, 33, 12, 23, 13)]),
    ],
)
def test_names(name: str, sensor: str, components: list[str]) -> None:
    found, indices = pick(swing(), name)
    assert found == sensor
    assert [swing().about(sensor)["components"][i] for i in indices] == components


def test_all_unknown_names_at_once_with_suggestions() -> None:
    with pytest.raises(jo.InputError) as error:
        jo.plot(swing(), "tpi", "tip.w", "enrgy")
    messages = [problem.message for problem in error.value.problems]
    assert messages == [
        "no sensor 'tpi'; did you mean 'tip'?",
        "sensor 'tip' has no component 'w'; known: x, y, z",
        "no sensor 'enrgy'; did you mean 'energy'?",
    ]


def test_without_names_all_sensors_and_two_units_two_panels() -> None:
    figure = jo.plot(swing())
    # powers of ten aside, which long units have in front
    units = [re.sub(r"^10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+ ", "", ax.get_ylabel()) for ax in figure.axes]
    assert units == ["m", "m/s", "√kg m", "√kg m/s", "N", "N m", "kPa"]
    assert [ax.get_title(loc="left") for ax in figure.axes][2:4] == ["modes", "modes"]


def test_stress_panels_leave_out_zero_components() -> None:
    (ax,) = jo.plot(swing(), "stress").axes
    assert len(ax.get_lines()) < 12
    assert "e1.a.top s11" in [text.get_text() for text in ax.texts]


def test_numbers_are_short_by_prefix() -> None:
    (ax,) = jo.plot(swing(), "stress.e1.a.top:s11").axes
    largest = np.abs(swing()["stress"][:, 0]).max()
    assert 1e4 < largest
    assert ax.get_ylabel() == "kPa"
    assert ax.yaxis.get_major_formatter()(2500.0, 0) == "2.5"
    assert ax.yaxis.get_major_formatter()(-2500.0, 0) == "\N{MINUS SIGN}2.5"


def test_energy_and_residuals() -> None:
    above, below, last = jo.plot(swing(), "energy", "residuals").axes
    assert [text.get_text() for text in above.texts[1:]] == [
        "kinetic",
        "strain",
        "potential",
        "total",
    ]
    np.testing.assert_array_equal(below.get_lines()[0].get_ydata(), swing().energy.error)
    assert last.get_yscale() == "log"
    assert all(np.all(line.get_ydata() > 0) for line in last.get_lines())


def test_several_runs_lie_over_one_another() -> None:
    figure = jo.plot({"1 ms": swing(), "0.5 ms": swing(5e-4)}, "tip.x")
    (ax,) = figure.axes
    first, second = ax.get_lines()
    assert first.get_linewidth() > 2 * second.get_linewidth()
    assert to_hex(first.get_color()) != to_hex(second.get_color())
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["1 ms", "0.5 ms"]
    with pytest.raises(jo.InputError, match="no run to draw"):
        jo.plot({}, "tip")


def test_a_component_keeps_its_colour_in_all_runs():
    labels = ("a", "b", "c", "d", "e", "f")
    for name in ("tip", "tip.y"):
        figure = jo.plot({label: swing() for label in labels}, name)
        looks = {}
        for k, line in enumerate(figure.axes[0].lines):
            run, component = divmod(k, len(figure.axes[0].lines) // len(labels))
            rgb = np.array(to_rgb(line.get_color()))
            hue = 1.0 - rgb
            looks.setdefault(run, set()).add((line.get_linewidth(), str(line._dash_pattern)))
            # mixed with white or not, it is the colour of the component
            own = 1.0 - np.array(to_rgb(COLORS[component]))
            np.testing.assert_allclose(hue / hue.max(), own / own.max(), atol=1e-9)
            if 0 < run <= len(DASHES):
                np.testing.assert_allclose(hue, own)
        # a run has one kind of line, and no other run up to the fourth has it
        assert all(len(look) == 1 for look in looks.values())
        kinds = [look.pop() for look in looks.values()]
        assert len(set(kinds[:5])) == 5


def test_eight_runs_look_different():
    figure = jo.plot({label: swing() for label in "abcdefgh"}, "tip.y")
    looks = [(x.get_color(), x.get_linewidth(), str(x._dash_pattern)) for x in figure.axes[0].lines]
    assert len(set(looks)) == 8
    assert len({(width, dashes) for _, width, dashes in looks}) == 8


def test_no_global_state() -> None:
    import matplotlib.pyplot as plt

    before = dict(matplotlib.rcParams)
    jo.plot(swing(), "tip")
    assert dict(matplotlib.rcParams) == before
    assert plt.get_fignums() == []


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf", "jpg", "webp"])
def test_formats_and_repeatability(suffix: str, tmp_path: Path) -> None:
    paths = [tmp_path / f"{k}.{suffix}" for k in "ab"]
    for path in paths:
        jo.plot(swing(), "tip", path=path)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    assert paths[0].stat().st_size > 5000


def test_picture_in_notebooks() -> None:
    assert jo.plot(swing(), "tip")._repr_png_().startswith(b"\x89PNG")


def test_bad_targets_are_refused_before_drawing(tmp_path: Path) -> None:
    with pytest.raises(jo.InputError, match=r"'.bmp' is not a format to write here; known: .png"):
        jo.plot(swing(), path=tmp_path / "a.bmp")
    with pytest.raises(jo.InputError, match="there is no suffix"):
        jo.plot(swing(), path=tmp_path / "a")
    with pytest.raises(jo.InputError, match="does not exist; create it first"):
        jo.plot(swing(), path=tmp_path / "no" / "a.png")
    (tmp_path / "b.png").mkdir()
    with pytest.raises(jo.InputError, match="is a folder"):
        jo.plot(swing(), path=tmp_path / "b.png")
    with pytest.raises(jo.InputError, match="cannot be written: .*choose another place"):
        jo.plot(swing(), "tip", path=tmp_path / f"{'x' * 300}.png")


def test_long_runs_are_thinned_to_their_extremes(rng: np.random.Generator) -> None:
    t = np.linspace(0.0, 1.0, 100_001)
    y = rng.normal(size=len(t))
    few_t, few_y = thin(t, y)
    assert len(few_t) < 3500
    assert (few_y.min(), few_y.max()) == (y.min(), y.max())
    assert (few_t[0], few_t[-1]) == (0.0, 1.0)
    assert np.all(np.diff(few_t) > 0)
    same_t, same_y = thin(t[:100], y[:100])
    np.testing.assert_array_equal(same_y, y[:100])
    steps_t, steps_y = envelope(t, y)
    assert len(steps_t) == len(steps_y) == 2 * STEPS
    assert steps_y.max() == y.max()


def test_labels_keep_their_distance_and_order(rng: np.random.Generator) -> None:
    wanted = rng.uniform(0.3, 0.5, size=8)
    places = spread(wanted, 0.05)
    assert np.all(np.argsort(places) == np.argsort(wanted))
    assert np.diff(np.sort(places)).min() > 0.05 - 1e-12
    far = np.array([0.9, 0.1])
    np.testing.assert_allclose(spread(far, 0.05), far)


def test_the_picture_is_not_empty(tmp_path: Path) -> None:
    jo.plot(swing(), "tip", path=tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        pixels = np.asarray(picture.convert("RGB"))
    assert pixels[0, 0].tolist() == [255, 255, 255]
    blue = np.all(pixels == (0x1C, 0x5F, 0xA8), axis=2)
    assert blue.sum() > 500


def test_rounding_is_drawn_as_zero() -> None:
    """A plane pendulum in a plane that lies odd: its bearing has forces and no moments."""
    ball = jo.RigidBody("ball", 2.0, (0.01, 0.01, 0.01), position=(0.36, 0.48, 0.8))
    far, axis = ball.at(-ball.position), (0.8, -0.6, 0.0)
    pivot = jo.Revolute("pivot", jo.ground["origin"], far, axis=axis)
    load = jo.ReactionSensor("load", pivot)
    run = jo.simulate(jo.compile(jo.Mechanism(ball, pivot, jo.Gravity((0, 0, -9.81)), load)), 0.5)
    noise = np.abs(run["load"][:, 3:]).max()
    assert 0.0 < noise < 1e-12  # beside 20 N at 1 m
    forces, moments = jo.plot(run, "load").axes
    assert max(np.abs(line.get_ydata()).max() for line in forces.lines) > 10.0
    assert all(not np.any(line.get_ydata()) for line in moments.lines)
