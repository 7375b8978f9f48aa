"""Shape functions: closed forms, Ritz' bounds, whole bases against the mesh, refusals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg as la
from numpy.typing import NDArray

import jousto as jo
from jousto.reduction import (
    AsGiven,
    BeamFunctions,
    ChordFrame,
    NodeFrame,
    Polynomials,
    ShapeFunctions,
    Splines,
    in_frame,
)
from jousto.reduction.shapes.line import ENDS, eigenfunction, root
from parts.grids import grid
from reduction.bodies import bent

Array = NDArray[np.float64]
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
SECTION = jo.Rectangle(0.02, 0.01)
# Thomson, Theory of Vibration with Applications, appendix D; the fourth is asymptotic, to 1e-5
TABLE = {
    "clamped-free": (1.8751, 4.6941, 7.8548, 3.5 * np.pi),
    "free-free": (4.7300, 7.8532, 10.9956, 4.5 * np.pi),
    "clamped-clamped": (4.7300, 7.8532, 10.9956, 4.5 * np.pi),
    "clamped-pinned": (3.9266, 7.0686, 10.2102, 4.25 * np.pi),
    "pinned-pinned": tuple(np.pi * k for k in range(1, 5)),
}


def beam(elements: int = 40) -> jo.Part:
    return jo.Part.beam(
        1.0, SECTION, elements, STEEL, theory=jo.parts.EulerBernoulli(), rotary_inertia=True
    )


@pytest.mark.parametrize("ends", TABLE)
def test_roots_of_the_handbook(ends: str) -> None:
    # four decimals are printed
    assert [root(ends, k) for k in range(1, 5)] == pytest.approx(TABLE[ends], abs=6e-5)


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("k", [1, 2, 7, 60])
def test_eigenfunctions(ends: str, k: int) -> None:
    """Equation, ends, derivative and norm, to round-off also at high order."""
    b, x = root(ends, k), np.linspace(0.0, 1.0, 401)
    w = eigenfunction(ends, k, x)
    fourth = eigenfunction(ends, k, x, 4) / b**4
    np.testing.assert_allclose(fourth, w, atol=1e-12 * np.abs(w).max())
    for end, at in zip(ends.split("-"), (0.0, 1.0), strict=True):
        for order in {"clamped": (0, 1), "pinned": (0, 2), "free": (2, 3)}[end]:
            assert abs(eigenfunction(ends, k, np.array([at]), order)[0]) / b**order < 1e-12
    h = 1e-30
    for order in range(4):
        slope = eigenfunction(ends, k, (x + 1j * h).astype(complex), order).imag / h  # type: ignore[arg-type]
        exact = eigenfunction(ends, k, x, order + 1)
        np.testing.assert_allclose(slope, exact, atol=1e-12 * b ** (order + 1))
    y, weight = np.polynomial.legendre.leggauss(300)
    at = 0.5 * (1.0 + y)
    own = 0.5 * weight * eigenfunction(ends, k, at)
    assert own @ eigenfunction(ends, k, at) == pytest.approx(1.0, abs=1e-12)
    # orthogonal to the others of these ends
    assert abs(own @ eigenfunction(ends, k + 1, at)) < 1e-11


@pytest.mark.parametrize(
    ("ends", "frame"),
    [
        ("clamped-free", NodeFrame("start")),
        ("free-clamped", NodeFrame("end")),
        ("pinned-pinned", ChordFrame("start", "end")),
        ("free-free", None),
    ],
)
def test_frequencies_of_the_closed_form(ends: str, frame: Any) -> None:
    """With the frame that the ends mean, w = b^2 sqrt(E I/(rho A))."""
    by = ShapeFunctions(BeamFunctions(ends, 4, across="z"), frame=frame)
    thin = jo.Rectangle(0.02, 0.002)
    part = jo.Part.beam(1.0, thin, 40, STEEL, theory=jo.parts.EulerBernoulli())
    found = jo.reduce(part, by).frequencies
    plain = {"free-clamped": "clamped-free"}.get(ends, ends)
    I = min(thin.Iy, thin.Iz)
    unit = np.sqrt(STEEL.E * I / (STEEL.rho * thin.A)) / (2.0 * np.pi)
    # the mesh interpolates the fourth to (b h)^4/720 = 2e-5, rotary inertia takes (b t)^2/24
    exact = unit * np.array(TABLE[plain][:4]) ** 2
    np.testing.assert_allclose(found, exact, rtol=2e-4)


def test_as_given_is_the_frame_of_the_ends() -> None:
    part = beam(10)
    for ends, frame in (
        ("clamped-free", NodeFrame("start")),
        ("pinned-pinned", ChordFrame("start", "end")),
    ):
        functions = BeamFunctions(ends, 3, 0, 2)
        given = jo.reduce(part, ShapeFunctions(functions, frame=AsGiven()))
        asked = jo.reduce(part, ShapeFunctions(functions, frame=frame))
        np.testing.assert_allclose(given.frequencies, asked.frequencies, rtol=1e-9)
        start = given.modes[given.node("start")]
        assert np.abs(start).max() < 1e-9 * np.abs(given.modes).max()


def test_all_columns_are_the_mesh(rng: np.random.Generator) -> None:
    """As many independent functions as the mesh has deformations: its modes, whatever they are."""
    part = bent(elements=2)
    ndof = part.K.shape[0]
    functions = rng.normal(size=(ndof, ndof - 6))
    found = jo.reduce(part, ShapeFunctions(functions))
    K, M = part.K.toarray(), part.M.toarray()
    exact = np.sqrt(np.abs(la.eigh(K, M, eigvals_only=True)[6:])) / (2.0 * np.pi)
    np.testing.assert_allclose(found.frequencies[:20], exact[:20], rtol=1e-6)
    np.testing.assert_allclose(found.invariants.I3, 0.0, atol=1e-8)


@pytest.mark.parametrize(
    "family",
    [
        lambda n: Polynomials(n + 3),
        lambda n: Splines(n + 7, degree=5),
        lambda n: BeamFunctions("free-free", n),
        lambda n: BeamFunctions("clamped-free", n),
    ],
    ids=["polynomials", "splines", "free", "clamped"],
)
def test_frequencies_fall_to_those_of_the_mesh(family: Any) -> None:
    """Ritz' values are upper bounds and fall with more functions (here bending only)."""
    part = beam(24)
    exact = jo.reduce(part, jo.FreeFree(modes=4)).frequencies
    before = np.full(4, np.inf)
    for n in (2, 4, 6):
        found = jo.reduce(part, ShapeFunctions(family(n))).frequencies[:4]
        assert np.all(found > exact * (1.0 - 1e-9))
        assert np.all(found < before * (1.0 + 1e-9))
        before = found
    np.testing.assert_allclose(before, exact, rtol=4e-3)


def test_polynomials_on_a_solid() -> None:
    """Bending, twist and stretch of a bar of 20-node hexahedra by 3-D polynomials."""
    mesh = grid("hexahedron20", (12, 2, 2), (0.6, 0.06, 0.04))
    part = jo.Part.solid(mesh, STEEL, interfaces=[_end(mesh)])
    exact = jo.reduce(part, jo.FreeFree(modes=6)).frequencies
    found = jo.reduce(part, ShapeFunctions(Polynomials(8, along="x", across=4)))
    assert np.all(found.frequencies[:6] > exact * (1.0 - 1e-9))
    np.testing.assert_allclose(found.frequencies[:6], exact, rtol=5e-3)
    assert jo.certificate.certify(part, found)["modes"].status == "ok"
    # sections that stay plane and keep their shape are stiffer
    plane = jo.reduce(part, ShapeFunctions(Polynomials(8, along="x", across=1)))
    assert plane.frequencies[0] > 1.02 * found.frequencies[0]


def _end(mesh: Any) -> jo.Interface:
    return jo.Interface("start", np.flatnonzero(mesh.nodes[:, 0] < 1e-9))


def test_rigid_ties_hold() -> None:
    """A tied surface stays plane whatever the functions say."""
    mesh = grid("hexahedron20", (6, 1, 1), (0.6, 0.06, 0.04))
    part = jo.Part.solid(mesh, STEEL, interfaces=[_end(mesh)])
    (tie,) = part.ties
    assert tie.kind == "rigid"
    found = jo.reduce(
        part,
        ShapeFunctions(
            lambda x: np.stack([x[:, 1] ** 2 + x[:, 0] ** 2, x[:, 0] ** 3, 0 * x[:, 0]], axis=1)
        ),
    )
    X = found.modes[: len(part.nodes)].reshape(-1, found.n)
    q = tie.averaging @ X[tie.dofs]
    following = tie.following.reshape(-1, 6) @ q
    np.testing.assert_allclose(following, X[tie.dofs], atol=1e-12 * np.abs(X).max())


def test_statics_of_interfaces() -> None:
    """Attachment modes make loads on the interfaces exact, as for free-free modes."""
    part = beam(10)
    found = jo.reduce(part, ShapeFunctions(BeamFunctions("pinned-pinned", 1), ("start", "end")))
    assert jo.certificate.certify(part, found)["static loads"].status == "ok"


def test_rotations_of_least_energy() -> None:
    """What a function leaves out, K_rr theta + K_ru u = 0; given ones stay."""
    part = bent(elements=3)

    def bow(x: Array) -> Array:
        return np.stack([0.1 * x[:, 1] ** 2, x[:, 0] ** 2, x[:, 0] * x[:, 2]], axis=1)

    found = jo.reduce(part, ShapeFunctions(bow))
    assert found.rotations is not None
    d = np.concatenate([found.modes, found.rotations], axis=1).reshape(-1)
    force = (part.K @ d).reshape(-1, 6)
    stiff = (abs(part.K) @ np.abs(d)).reshape(-1, 6)
    assert np.abs(force[:, 3:]).max() < 1e-8 * stiff[:, 3:].max()


def test_rotations_that_are_given() -> None:
    """A straight beam whose nodes do not turn as it bends is far stiffer."""

    def told(x: Array) -> Array:
        return np.concatenate([square(x), np.zeros(x.shape)], axis=1)

    loose, tight = (jo.reduce(beam(8), ShapeFunctions(f)).frequencies[0] for f in (square, told))
    assert tight > 5.0 * loose


def test_machines_of_shape_functions() -> None:
    """A cantilever of polynomials under a force: deflection, stress at the root, spin."""
    part = beam(8)
    rod = jo.FlexibleBody("rod", jo.reduce(part, ShapeFunctions(Polynomials(6))))
    wall = jo.Fixed("wall", jo.ground["origin"], rod["start"])
    tip = jo.PositionSensor("tip", rod["end"])
    machine = jo.Mechanism(rod, wall, jo.Force("load", rod["end"], (0.0, 0.0, -0.1)), tip)
    state = jo.equilibrium(jo.compile(machine))
    stress = rod.reduced.stress
    assert stress is not None
    root_stress = stress.modes[stress.labels.index("e1.a.top")] @ state.q[7:]
    assert root_stress[0] == pytest.approx(0.1 / (0.02 * 0.01**2 / 6.0), rel=1e-4)


def test_in_model_files(tmp_path: Path) -> None:
    file = tmp_path / "rod.yaml"
    text = (
        "parts:\n  rod:\n    type: beam\n    length: 1\n"
        "    section: {type: rectangle, width: 0.02, height: 0.01}\n    elements: 8\n"
        "    material: {E: 2.0e11, nu: 0.3, rho: 7850}\n"
        "    reduce:\n      type: shape-functions\n      frame: {type: as-given}\n"
        "      functions: %s\n"
        "bodies:\n  - {name: rod, part: rod}\n"
        "joints:\n  - {type: fixed, name: pin, a: ground.origin, b: rod.start}\n"
    )
    both = "[{type: beam, ends: clamped-free, bending: 2}, {type: polynomials, order: 3}]"
    for functions, n in (
        ("{type: beam, ends: clamped-free, bending: 2}", 4),
        ("{type: splines, bending: 5, twist: 5}", 2 * 3 + 4),
        (both, None),
    ):
        file.write_text(text % functions)
        (body,) = jo.read_model(file).mechanism.bodies
        assert n is None or body.reduced.n == n
        assert body.reduced.provenance["method"].startswith("ShapeFunctions(")
    file.write_text(text % "{type: beam, ends: clamped, bending: 2}")
    with pytest.raises(jo.InputError, match="functions"):
        jo.read_model(file)


def test_methods_are_compared_by_content() -> None:
    a = np.arange(12.0)
    assert ShapeFunctions(a) == ShapeFunctions(a.copy()) != ShapeFunctions(a + 1.0)
    assert ShapeFunctions(Polynomials(3)) == ShapeFunctions([Polynomials(3)])
    assert "columns" in repr(ShapeFunctions(a))
    assert ShapeFunctions(np.sin) == ShapeFunctions(np.sin) != ShapeFunctions(np.cos)


def nowhere(x: Array) -> Array:
    return np.where(x > 0.5, np.nan, x**2)


def shift(x: Array) -> Array:
    return np.ones(x.shape)


def spin(x: Array) -> Array:
    turn = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    return np.concatenate([np.cross(turn, x), turn], axis=1)


def still(x: Array) -> Array:
    return 0.0 * x


def square(x: Array) -> Array:
    return np.stack([0 * x[:, 0], x[:, 0] ** 2, 0 * x[:, 0]], axis=1)


def moved_square(x: Array) -> Array:
    return square(x) + [0.0, 3.0, 0.0]


def one(x: Array) -> Array:
    return x[:, 0]


def broken(x: Array) -> Array:
    raise ZeroDivisionError("no luck")


@pytest.mark.parametrize(
    ("functions", "message"),
    [
        (nowhere, r"shape function 'nowhere' is not finite at node6"),
        (shift, r"'shift': a rigid motion, which the body frame already has; leave it out"),
        (spin, r"'spin': a rigid motion"),
        (still, r"'still': zero at all nodes"),
        ([square, square], r"'square': at the nodes a linear combination of the previous ones"),
        (
            [square, moved_square],
            r"'moved_square': a linear combination of the previous ones and a rigid motion",
        ),
        (one, r"'one' returns an array \(9,\) for the 9 nodes, must be \(9, 3\) or \(9, 6\)"),
        (broken, r"'broken' failed at the nodes: ZeroDivisionError: no luck"),
        (np.ones(7), r"by columns have 7 rows, the part has 54 degrees of freedom"),
        (
            Polynomials(9),
            r"x\^9 in x, x\^9 in y, x\^9 in z and 3 more: at the nodes a linear combination",
        ),
        (BeamFunctions("free-free", 2, axis="y"), "has no extent along y"),
        (BeamFunctions("free-free", 0, 9), "stretch 9 along x: at the nodes a linear combination"),
    ],
)
def test_refused_by_the_part(functions: Any, message: str) -> None:
    part = jo.Part.beam(1.0, SECTION, 8, STEEL)
    with pytest.raises(jo.InputError, match=message):
        jo.reduce(part, ShapeFunctions(functions))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ShapeFunctions([]), "functions is empty"),
        (lambda: ShapeFunctions(3.0), "function 3.0 is not a shape function: give BeamFunctions"),
        (lambda: ShapeFunctions(np.array([1.0, np.inf])), "columns of shape functions"),
        (lambda: ShapeFunctions(square, modes=0), "modes"),
        (lambda: BeamFunctions("clamped", 2), "ends is 'clamped'"),
        (lambda: BeamFunctions("free-free", 0), "has no function"),
        (lambda: BeamFunctions("free-free", 61), "at most 60"),
        (lambda: BeamFunctions("free-free", 2, across="x"), "across is 'x', the same as axis"),
        (lambda: Splines(3), "3 functions of degree 3, at least 4"),
        (lambda: Splines(30, degree=12), "degree 12, at most"),
        (lambda: Polynomials(1), "order"),
        (lambda: Polynomials(4, along="x"), "along and across must both"),
        (lambda: jo.FreeFree(modes=3, frame=AsGiven()), "which is allowed for ShapeFunctions(...)"),
    ],
)
def test_refused_at_once(make: Any, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        make()


def test_all_mistakes_at_once() -> None:
    part = jo.Part.beam(1.0, SECTION, 8, STEEL)
    with pytest.raises(jo.InputError) as error:
        jo.reduce(part, ShapeFunctions([shift, still, square, square]))
    assert len(error.value.problems) == 3


def test_seen_from_another_frame_it_stiffens() -> None:
    """Shape functions carry the second-order field, and keep it in another frame."""
    part = beam(8)
    rod = jo.reduce(part, ShapeFunctions(Polynomials(5)), stiffening=True)
    held = in_frame(rod, NodeFrame("start"))
    assert rod.stiffening is not None and held.stiffening is not None


def test_functions_that_can_turn_the_whole_body_are_named() -> None:
    """From a node frame, many polynomials span nearly all rigid motions of a bent beam."""
    part = jo.Part.beam(1.0, SECTION, 20, STEEL)
    red = jo.reduce(part, ShapeFunctions(Polynomials(10), frame=NodeFrame("start")))
    body = jo.FlexibleBody("beam", red)
    root = jo.Fixed("root", jo.ground["origin"], body["start"])
    model = jo.compile(jo.Mechanism(body, root, jo.Gravity((0, 0, -9.81))))
    with pytest.raises(jo.InputError, match="body 'beam': its mass matrix is singular: its modes"):
        jo.simulation.load_path(model, "gravity", to=1.0, steps=1)
