"""Pictures of fatigue show what was counted."""

import numpy as np
import pytest

import jousto as jo
from jousto.output.surface import Skin
from output.blocks import swinging_bar
from output.runs import swing

CURVE = jo.SN(S_D=1e6, N_D=1e6, k=5, name="bar")


def test_sn_plot_holds_the_curve():
    figure = jo.plot_sn(jo.SN(S_D=100e6, N_D=1e6, k=5, rule="original"))
    N, S = figure.axes[0].lines[0].get_data()
    assert S[np.argmin(np.abs(N - 1e6))] == pytest.approx(100.0, rel=0.02)
    assert S[-1] == pytest.approx(100.0)


def test_cycles_plot(tmp_path):
    history = np.random.default_rng(1).normal(size=3000) * 1e6
    cycles = jo.rainflow(history, residue="half")
    figure = jo.plot_cycles(cycles, CURVE, path=tmp_path / "cycles.svg")
    assert [ax.get_title(loc="left") for ax in figure.axes if ax.get_title(loc="left")] == [
        "rainflow matrix",
        "level crossings",
        "S-N curve and cycles, residue: half",
    ]
    assert (tmp_path / "cycles.svg").stat().st_size > 1000
    with pytest.raises(jo.InputError, match="there are no cycles"):
        jo.plot_cycles(jo.rainflow([1.0, 1.0], residue="half"))


@pytest.mark.parametrize("quantity", ["damage", "life", "safety"])
def test_damage_of_a_beam(tmp_path, quantity):
    run = swing()
    found = jo.damage_field(jo.stress_field(run, "arm"), CURVE, residue="half")
    figure = jo.plot_damage(run, found, tmp_path / "d.png", quantity=quantity)
    texts = [t.get_text() for t in figure.texts]
    assert any(text.startswith(f"{quantity} of arm: bar") for text in texts)
    with pytest.raises(jo.InputError, match="did you mean 'safety'"):
        jo.plot_damage(run, found, quantity="safty")


def test_damage_of_a_solid_is_painted_on_its_surface(tmp_path):
    run = swinging_bar()
    field = jo.stress_field(run, "bar", times=np.linspace(0, 0.2, 11))
    found = jo.damage_field(field, jo.SN(S_D=5e5, N_D=1e6, k=5), criterion="s11", residue="half")
    figure = jo.plot_damage(run, found, tmp_path / "d.png")
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
    mesh = meshio.read(jo.write_damage(run, found, tmp_path / "d.vtu"))
    assert mesh.point_data["damage"].max() == pytest.approx(found.damage.max())
    assert mesh.point_data["life (s)"].min() == pytest.approx(found.life.min())
