"""Stress of beams as of other bodies: closed forms, hot spots, damage, against a modal body."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from recovery.beams.cases import STEEL, cantilever, compiled, rest

SN = jo.SN(100e6, 1e6, 3)


@pytest.fixture(scope="module")
def bent() -> jo.Solution:
    return cantilever((0.0, 3.0, -10.0), 4)


def test_bending_stress_of_a_cantilever(bent: jo.Solution) -> None:
    """6 P L / (b h^2) at the clamp, from both directions at a corner."""
    field = jo.stress_field(bent, "beam")
    found = field.envelope("s11")
    k = int(np.argmax(found.max))
    exact = 6.0 * 10.0 / (0.02 * 0.04**2) + 6.0 * 3.0 / (0.04 * 0.02**2)
    assert found.labels[k] == "e1.a.top_right" and found.max[k] == pytest.approx(exact, rel=1e-5)
    assert field.at(0.0, "e1.a.bottom_left")[0, 0] == pytest.approx(-exact, rel=1e-5)
    # Jourawski: 3/2 of the mean shear
    centre = field.history("e3.b.centre")[-1]
    assert centre[5] == pytest.approx(-1.5 * 10.0 / 8e-4, rel=1e-4)
    assert centre[3] == pytest.approx(1.5 * 3.0 / 8e-4, rel=1e-4)


def test_every_way_to_the_values_agrees(bent: jo.Solution, tmp_path: Path) -> None:
    field = jo.stress_field(bent, "beam")
    whole = field.values("von-mises")
    from jousto.recovery.fields.criteria import evaluate

    assert whole == pytest.approx(evaluate(field.history(slice(None))), rel=1e-12)
    places = [40, 3, 17, 4]
    assert field.take(places).values("von-mises") == pytest.approx(whole[:, places], rel=1e-12)
    for along in ("time", "sites"):
        out = np.full_like(whole, np.nan)
        for t, s, values in field.blocks(memory=8 * 70, along=along):
            assert np.all(np.isnan(out[t, s]))
            out[t, s] = values
        assert out == pytest.approx(whole, rel=1e-12)
    found = field.envelope()
    assert found.max == pytest.approx(whole.max(axis=0), rel=1e-12)
    assert found.min == pytest.approx(whole.min(axis=0), rel=1e-12)
    import h5py

    with h5py.File(field.write(tmp_path / "field.h5")) as file:
        assert file["values/von-mises"][()] == pytest.approx(whole, rel=1e-12)
    assert field.at(1e-9) == pytest.approx(field.history(slice(None))[1])


@pytest.mark.parametrize("criterion", ["von-mises", "s11", "principal-3", "signed-von-mises"])
def test_hot_spots_are_the_largest_of_all(bent: jo.Solution, criterion: str) -> None:
    field = jo.stress_field(bent, "beam")
    found = jo.hot_spots(field, criterion=criterion, count=4, separation=0.0)
    values = field.values(criterion)
    size = -values if criterion == "principal-3" else np.abs(values)
    best = np.sort(size.max(axis=0))[::-1][:4]
    assert [abs(spot.value) for spot in found] == pytest.approx(best, rel=1e-9)
    assert found.certified
    far = jo.hot_spots(bent, count=3, separation=0.2)
    x = np.array([spot.position for spot in far])
    assert np.linalg.norm(x[0] - x[1]) > 0.2 and far[0].body == "beam"
    assert len(jo.hot_spots(field, count=10**4, separation=0.0)) == field.ns


ROUNDS = [jo.Circle(0.02), jo.Tube(0.02, 0.002)]


@pytest.mark.parametrize("section", ROUNDS, ids=["circle", "tube"])
@pytest.mark.parametrize("angle", [0.0, 7.5, 22.5, 45.0, 200.0])
def test_oblique_bending_of_a_round_beam(section: jo.Circle | jo.Tube, angle: float) -> None:
    """M r / I in whatever plane the beam is bent; 25.5 MPa of 20 Nm on the circle."""
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    run = cantilever((0.0, 20.0 * c, 20.0 * s), 4, section)
    found = jo.hot_spots(run, criterion="s11", count=1)
    assert abs(found[0].value) == pytest.approx(20.0 * 0.01 / section.Iy, rel=0.01)


@pytest.mark.parametrize("section", ROUNDS, ids=["circle", "tube"])
def test_fatigue_of_a_round_beam_has_no_preferred_direction(section: jo.Circle | jo.Tube) -> None:
    """A force that swings to and fro damages alike in every plane: within 1 % as stress."""
    swing = jo.Table([0.0, 1.0, 2.0, 3.0], [0.0, 300.0, -300.0, 0.0])
    life = []
    for angle in (0.0, 7.5, 40.0, 45.0):
        c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
        beam = jo.BeamBody(
            "beam",
            [(0, 0, 0), (1, 0, 0)],
            section,
            STEEL,
            elements=3,
            damping=jo.mechanism.BeamDamping(mass=150.0),
        )
        model = compiled(
            beam,
            jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
            jo.Force("push", beam["end"], (0.0, c, s), signal=swing),
        )
        run = jo.simulate(model, t_end=3.0, solver=jo.GeneralizedAlpha(step=0.02, rho=0.5))
        damage = jo.damage_field(jo.stress_field(run, "beam"), SN, residue="half")
        life.append(damage.damage.max())
    # as stress: the third root
    assert np.cbrt(life) == pytest.approx(np.cbrt(life[0]), rel=0.01)


def test_strain_and_other_axes(bent: jo.Solution) -> None:
    strain = jo.stress_field(bent, "beam", sites="e1.a.top", strain=True)
    stress = jo.stress_field(bent, "beam", sites="e1.a.top")
    e, s = strain.history("e1.a.top")[0], stress.history("e1.a.top")[0]
    assert e[0] == pytest.approx(s[0] / STEEL.E) and e[1] == pytest.approx(-0.3 * e[0])
    body = jo.stress_field(bent, "beam", sites="e1.a.top", frame="body")
    assert body.history("e1.a.top")[0, 0] == pytest.approx(s[0])
    with pytest.raises(jo.InputError, match="sections have different rotations"):
        jo.stress_field(bent, "beam", frame="world")
    with pytest.raises(jo.InputError, match="no stress site or set 'e9.a.top'"):
        jo.stress_field(bent, "beam", sites="e9.a.top")
    with pytest.raises(jo.InputError, match="a beam has no reduced part"):
        jo.stress_field(bent, "beam", residual=True)


def test_force_off_the_shear_centre_twists() -> None:
    """A channel pulled through its centroid: torque P e, shear T t / J (Timoshenko)."""
    e, t, J = 0.03, 0.003, 2.7e-9
    point = jo.sections.SectionPoint("web", -0.01, 0.0, ((0, 0, 0), (0, 0, t / J)))
    channel = jo.sections.GeneralSection(
        A=6e-4, Iy=3e-7, Iz=6e-8, J=J, ky=0.4, kz=0.4, points=(point,)
    )
    section = jo.mechanism.BeamSection.of(channel, STEEL, shear_center=(-e, 0.0))
    beam = jo.BeamBody("channel", [(0, 0, 0), (1, 0, 0)], section, elements=4)
    P = 0.01
    for at, torque in ((0.0, P * e), (-e, 0.0)):
        run = rest(
            compiled(
                beam,
                jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
                jo.Force("pull", beam.node(4, at=(0.0, at, 0.0)), (0.0, 0.0, P)),
            )
        )
        s = jo.stress_field(run, "channel").history("e2.a.web")[0]
        assert s[5] == pytest.approx(torque * t / J, rel=1e-5, abs=1e-3)
        # bending about y, of the size P L / A h, does not stress the web in the middle
        assert s[0] == pytest.approx(0.0, abs=1e-5 * P * 1.0 * 0.03 / 3e-7)


def test_composite_by_stress_points() -> None:
    rows = np.zeros((6, 6))
    rows[0, 0], rows[0, 4], rows[3, 3] = 2000.0, 5e5, 7e5
    C = (1e7, 4e6, 4e6, 50.0, 80.0, 90.0)
    points = [jo.sections.StressPoint("skin", 0.0, 0.01, rows)]
    run = cantilever(
        (0.0, 0.0, -0.01),
        3,
        jo.mechanism.BeamSection(C, 1.2, (2e-4, 1e-4, 1e-4), points=points),
        plain=True,
    )
    field = jo.stress_field(run, "beam")
    assert field.history("e1.a.skin")[0, 0] == pytest.approx(5e5 * 0.01, rel=1e-3)
    with pytest.raises(jo.InputError, match="material of its sites is not known"):
        jo.stress_field(run, "beam", strain=True)


def test_section_without_points_says_what_to_do() -> None:
    C = (1e7, 4e6, 4e6, 50.0, 80.0, 90.0)
    run = cantilever(
        (0, 0, 0.01), 3, jo.mechanism.BeamSection(C, 1.2, (2e-4, 1e-4, 1e-4)), plain=True
    )
    assert run.stressed == ()
    with pytest.raises(jo.InputError, match=r"BeamSection\(..., points=\[StressPoint"):
        jo.stress_field(run, "beam")
    with pytest.raises(jo.InputError, match="no body of this run has stress data"):
        jo.hot_spots(run)


def test_damage_is_that_of_the_same_modal_body() -> None:
    """Small deflections of a cantilever, once as a chain of exact elements, once by modes."""
    section, n = jo.Rectangle(0.02, 0.04), 8
    push = jo.Table([0.0, 0.3, 0.8, 1.2, 1.7, 2.2, 2.5], [0, 900, -500, 700, -900, 400, 0])
    beam = jo.BeamBody(
        "beam",
        [(0, 0, 0), (1, 0, 0)],
        section,
        STEEL,
        elements=n,
        damping=jo.mechanism.BeamDamping(mass=150.0),
    )
    part = jo.Part.beam(length=1.0, section=section, elements=n, material=STEEL, lumped=True)
    rod = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    modal = jo.FlexibleBody("modal", rod, damping=0.4, position=(0, 1, 0))
    model = compiled(
        beam,
        modal,
        jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
        jo.Fixed("other", jo.ground.at((0, 1, 0)), modal["start"]),
        jo.Force("push", beam["end"], (0, 0, 1.0), signal=push),
        jo.Force("same", modal["end"], (0, 0, 1.0), signal=push),
    )
    run = jo.simulate(model, t_end=2.5, solver=jo.GeneralizedAlpha(step=0.01, rho=0.5))
    fields = [jo.stress_field(run, name) for name in ("beam", "modal")]
    damage = [jo.damage_field(f, SN, residue="repeat") for f in fields]
    assert damage[0].worst(1)[0].startswith("e1.a.") and damage[1].worst(1)[0].startswith("e1.a.")
    a, b = (d.at("e1.a.top_left") for d in damage)
    # the third power of stress: 1 % of stress is 3 % of damage
    assert a[0] > 0.0 and a[0] == pytest.approx(b[0], rel=0.03)
    count = damage[0].cycles(fields[0], "e1.a.top_left")
    assert jo.fatigue.damage(count, SN) == pytest.approx(a[0], rel=1e-12)
    # the half near the tip stays below the endurance limit and is not counted
    limited = jo.damage_field(fields[0], jo.SN(100e6, 1e6, 3, "original"), residue="repeat")
    peak = np.abs(fields[0].values("signed-von-mises")).max(axis=0)
    assert np.array_equal(limited.counted, peak >= 100e6) and limited.pruned > 0


def test_a_long_beam_needs_memory_in_proportion() -> None:
    beam = jo.BeamBody("long", [(0, 0, 0), (20, 0, 0)], jo.Circle(0.02), STEEL, elements=400)
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    model = compiled(beam, clamp, jo.Gravity((0.0, 0.0, -9.81)))
    run = jo.simulate(model, t_end=2e-4, solver=jo.GeneralizedAlpha(step=1e-4))
    field = jo.stress_field(run, "long")
    assert field.S.shape == (400 * 2 * 25, 6, 6) and field.p.shape == (3, 400 * 12)
    assert len(jo.hot_spots(field, count=2)) == 2
