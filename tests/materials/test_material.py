"""Materials: values, checks and hints about units."""

from __future__ import annotations

import warnings

import pytest

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material


def test_shear_modulus() -> None:
    assert Material(E=210e9, nu=0.25, rho=7850.0).G == 84e9
    assert Material(E=3e9, nu=0.5, rho=0.0).G == 1e9


@pytest.mark.parametrize(
    ("E", "nu", "rho", "message"),
    [
        (-1.0, 0.3, 7850.0, "Young's modulus E is -1 Pa"),
        (float("nan"), 0.3, 7850.0, "Young's modulus E is nan Pa"),
        (2e11, 0.6, 7850.0, "Poisson's ratio nu is 0.6"),
        (2e11, -1.0, 7850.0, "Poisson's ratio nu is -1"),
        (2e11, float("nan"), 7850.0, "Poisson's ratio nu is nan"),
        (2e11, 0.3, -7850.0, "density rho is -7850 kg/m^3"),
        (2e11, 0.3, float("inf"), "density rho is inf kg/m^3"),
    ],
)
def test_bad_values(E: float, nu: float, rho: float, message: str) -> None:
    with pytest.raises(InputError, match=message.replace("^", r"\^")):
        Material(E=E, nu=nu, rho=rho)


def test_all_problems_at_once() -> None:
    with pytest.raises(InputError) as caught:
        Material(E=0.0, nu=2.0, rho=-1.0, name="steel")
    assert len(caught.value.problems) == 3
    assert all(p.where == "material 'steel'" for p in caught.value.problems)


@pytest.mark.parametrize(
    ("E", "rho", "message"),
    [
        (210e3, 7850.0, "in MPa"),
        (210.0, 7850.0, "in GPa"),
        (2.1e8, 7850.0, "in kPa"),
        (210e9, 7.85, "in g/cm"),
        (210e12, 7850.0, "stiffer than diamond"),
        (210e9, 7.85e-9, "in t/mm"),
        (210e9, 7.85e6, "denser than any metal"),
    ],
)
def test_hints_about_units_point_at_the_caller(E: float, rho: float, message: str) -> None:
    with pytest.warns(JoustoWarning, match=message) as caught:
        Material(E=E, nu=0.3, rho=rho)
    assert caught[0].filename == __file__


@pytest.mark.parametrize(("length", "mass"), [(1e3, 1e-3), (1e6, 1e12)])
def test_steel_in_any_consistent_units(length: float, mass: float) -> None:
    """In mm and t, and in micrometres and ng, where E is 2.1e17: a bar sounds as in SI."""
    found = []
    for m, kg in ((1.0, 1.0), (length, mass)):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", JoustoWarning)
            steel = Material(E=210e9 * kg / m, nu=0.3, rho=7850.0 * kg / m**3)
        part = jo.Part.beam(1.0 * m, jo.Rectangle(0.02 * m, 0.04 * m), 4, steel)
        method = jo.CraigBampton(("start", "end"), modes=2)
        found.append(jo.reduce(part, method).frequencies)
    assert found[1] == pytest.approx(found[0], rel=1e-9)  # rounding of the eigenvalues


def test_ordinary_materials_give_no_hint() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        Material(E=1.0e9, nu=0.4, rho=900.0)  # polyethylene
        Material(E=650e9, nu=0.22, rho=15600.0)  # tungsten carbide
        Material(E=210e9, nu=0.3, rho=0.0)  # massless
    assert [str(w.message) for w in caught] == []
