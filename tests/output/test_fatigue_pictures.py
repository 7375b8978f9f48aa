"""Pictures of fatigue show what was counted."""

import numpy as np
import pytest

import jousto as jo
from jousto.output.figures.coloured_body import is_hidden, paint_body
from jousto.output.scenes.surface import Skin
from jousto.output.scenes.view import View
from jousto.output.style import Picture
from jousto.recovery.shape import find_body
from output.blocks import swinging_bar
from output.runs import swing

CURVE = jo.SN(S_D=1e6, N_D=1e6, k=5, name="bar")


def test_sn_plot_holds_the_curve():
    figure = jo.plot(jo.SN(S_D=100e6, N_D=1e6, k=5, rule="original"))
    N, S = figure.axes[0].lines[0].get_data()
    assert S[np.argmin(np.abs(N - 1e6))] == pytest.approx(100.0, rel=0.02)
    assert S[-1] == pytest.approx(100.0)


def test_cycles_plot(tmp_path):
    history = np.random.default_rng(1).normal(size=3000) * 1e6
    cycles = jo.fatigue.rainflow(history, residue="half")
    figure = jo.plot(cycles, CURVE, path=tmp_path / "cycles.svg")
    assert [ax.get_title(loc="left") for ax in figure.axes if ax.get_title(loc="left")] == [
        "rainflow matrix",
        "level crossings",
        "S-N curve and cycles, residue: half",
    ]
    assert (tmp_path / "cycles.svg").stat().st_size > 1000
    with pytest.raises(jo.InputError, match="there are no cycles"):
        jo.plot(jo.fatigue.rainflow([1.0, 1.0], residue="half"))


@pytest.mark.parametrize("quantity", ["damage", "life", "safety"])
def test_damage_of_a_beam(tmp_path, quantity):
    run = swing()
    found = jo.damage_field(jo.stress_field(run, "arm"), CURVE, residue="half")
    figure = jo.plot(found, run, quantity=quantity, path=tmp_path / "d.png")
    texts = [t.get_text() for t in figure.texts]
    assert any(text.startswith(f"{quantity} of arm: bar") for text in texts)
    assert any("mean stress: not corrected, residue: half, survival" in text for text in texts)
    assert any(text.startswith(f"1 {found.worst(1)[0]}, 2 e") for text in texts)
    corrected = jo.fatigue.Goodman(S_u=500e6)
    found = jo.damage_field(jo.stress_field(run, "arm"), CURVE, residue="half", mean=corrected)
    texts = [t.get_text() for t in jo.plot(found, run, quantity=quantity).texts]
    assert any(f"mean stress: {corrected}" in text for text in texts)
    with pytest.raises(jo.InputError, match="did you mean 'safety'"):
        jo.plot(found, run, quantity="safty")


def test_damage_of_a_solid_is_painted_on_its_surface(tmp_path):
    run = swinging_bar()
    field = jo.stress_field(run, "bar", times=np.linspace(0, 0.2, 11))
    found = jo.damage_field(field, jo.SN(S_D=5e5, N_D=1e6, k=5), criterion="s11", residue="half")
    figure = jo.plot(found, run, path=tmp_path / "d.png")
    skin = next(a for a in figure.axes[0].get_children() if isinstance(a, Skin))
    # stress grows along the bar: red at the far end, blue at the near one
    red = skin.shades[:, :, 0].mean(axis=1) - skin.shades[:, :, 2].mean(axis=1)
    assert red.max() > 0.3 and red.min() < -0.2
    worst = found.positions[found.labels.index(found.worst(1)[0])]
    assert worst[0] == pytest.approx(1.0)


def test_vtu_holds_the_worst_value_of_each_node(tmp_path):
    import meshio

    run = swing()
    found = jo.damage_field(jo.stress_field(run, "arm"), CURVE, residue="half")
    mesh = meshio.read(jo.write(found, tmp_path / "d.vtu", run))
    assert mesh.point_data["damage"].max() == pytest.approx(found.damage.max())
    assert mesh.point_data["life (s)"].min() == pytest.approx(found.life.min())


def test_places_behind_the_body_are_faded(tmp_path):
    """A box looked at along y: its front is seen, its back and what is inside are hidden."""
    run = swinging_bar()
    shape = find_body(run, "bar")
    eye = View.on("xz")
    x = eye.project(shape.nodes)
    front, back = shape.nodes[np.argmax(x[:, 2])], shape.nodes[np.argmin(x[:, 2])]
    middle = 0.5 * (shape.nodes.min(axis=0) + shape.nodes.max(axis=0))
    assert not is_hidden(shape, eye, front)
    assert is_hidden(shape, eye, back) and is_hidden(shape, eye, middle)
    # from the other side it is the other way round
    other = View((0.0, 1.0, 0.0))
    assert is_hidden(shape, other, front) and not is_hidden(shape, other, back)
    # the pictures say so
    field = jo.stress_field(run, "bar", times=np.linspace(0, 0.2, 11))
    found = jo.damage_field(field, jo.SN(S_D=5e5, N_D=1e6, k=5), criterion="s11", residue="half")
    kinds = set()
    for view in (eye, View((-0.9, -0.5, 0.3))):
        ax = jo.plot(found, run, view=view, marks=8).axes[0]
        for text, dot in zip(ax.texts, ax.lines, strict=True):
            bracket = text.get_text().startswith("(")
            kinds.add(bracket)
            assert (dot.get_alpha() < 1.0) == (text.get_alpha() < 1.0) == bracket
    assert kinds == {True, False}


def test_damage_and_hot_spots_are_painted_alike():
    """Lines between two nodes: straight for stress, in decades for damage."""
    run = swing()
    shape = find_body(run, "arm")
    values = np.geomspace(1e-6, 1.0, len(shape.nodes))
    for decades in (False, True):
        figure = Picture()
        ax = figure.add_axes((0, 0, 1, 1))
        seen = []
        paint_body(
            ax,
            shape,
            View.on("xz"),
            values,
            lambda of: (seen.append(of), np.zeros((len(of), 3)))[1],  # noqa: B023
            decades=decades,
        )
        a, b = values[shape.elements[0, :2]]
        share = (np.arange(8) + 0.5) / 8
        between = a ** (1 - share) * b**share if decades else a + share * (b - a)
        np.testing.assert_allclose(seen[0][:8], between, rtol=1e-9)
