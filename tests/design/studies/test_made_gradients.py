"""Gradients of machines from model files, of solids and of exact beams: powers by dimensions."""

from __future__ import annotations

from itertools import product

import numpy as np

import jousto as jo

P = jo.Parameter
FILE = """
parameters: {length: 2 m, width: 20 mm, E: 200 GPa}
parts:
  rod:
    type: beam
    length: ${length}
    section: {type: rectangle, width: "${width}", height: "${2 * width}"}
    elements: 4
    material: {E: "${E}", nu: 0.3, rho: 7850 kg/m^3}
    theory: {type: euler-bernoulli}
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 3}
bodies: [{name: rod, part: rod}]
joints: [{type: fixed, name: clamp, a: ground.origin, b: rod.start}]
"""


def powers(found):
    """x / y dy/dx (no, np): the powers of the parameters in the outcomes."""
    return found.jacobian * found.x / found.values[:, None]


def test_parameters_of_model_files_are_differentiated_by_complex_steps(tmp_path):
    path = tmp_path / "rod.yaml"
    path.write_text(FILE, encoding="utf-8")
    given = [P("length", 2.0, unit="m"), P("width", 0.02, unit="m"), P("E", 2e11, unit="Pa")]
    found = jo.design.gradient(jo.study(jo.read_model(path), given, ["frequency(1)", "mass"]))
    assert {how for row in found.how for how in row} == {"complex step"}
    length, width, E = powers(found)[0]
    # sqrt(E / rho) over a length, by all lengths together; the rotary inertia is (w / l)^2 of it
    np.testing.assert_allclose([length + width, E], [-1.0, 0.5], rtol=1e-9)
    np.testing.assert_allclose(powers(found)[1], [1.0, 2.0, 0.0], rtol=1e-12)


def test_solids_are_differentiated_by_the_models_beside_them():
    def block(E, rho, scale):
        x = np.linspace(0.0, 1.0, 5)
        nodes = float(scale) * np.array([[x, y, z] for z, y, x in product((-1, 1), (-1, 1), x)])
        cells = [(i, i + 1, i + 6, i + 5, i + 10, i + 11, i + 16, i + 15) for i in range(4)]
        mesh = jo.Mesh("block", nodes * (1.0, 0.05, 0.05), jo.mesh.Cells("hexahedron", cells))
        ends = [jo.Interface(name, nodes=[i, i + 5, i + 10, i + 15]) for name, i in ENDS]
        part = jo.Part.solid(mesh, jo.Material(E, 0.3, rho), interfaces=ends)
        body = jo.FlexibleBody("block", jo.reduce(part, jo.CraigBampton(("root", "tip"), modes=3)))
        return jo.Mechanism(body, jo.Fixed("clamp", jo.ground["origin"], body["root"]))

    ENDS = (("root", 0), ("tip", 4))
    given = [P("E", 2e11), P("rho", 7850.0), P("scale", 1.2)]
    found = jo.design.gradient(jo.study(block, given, ["frequency(1)", "mass"]))
    assert found.exact and all(how.startswith("complex run: ") for how in found.how[0])
    # steps of 1e-3: 4e-12 times products of powers; round-off of the modes over the step
    np.testing.assert_allclose(powers(found)[0], [0.5, -0.5, -1.0], rtol=1e-8)
    np.testing.assert_allclose(powers(found)[1], [0.0, 1.0, 3.0], rtol=1e-9, atol=1e-12)


def test_exact_beams_are_differentiated_by_the_models_beside_them():
    def beam(E, width):
        steel = jo.Material(E, 0.3, 7850.0)
        line = [(0, 0, 0), (1, 0, 0)]
        body = jo.BeamBody("rope", line, jo.Rectangle(width, 0.03), steel, elements=2)
        clamp = jo.Fixed("clamp", jo.ground["origin"], body["start"])
        push = jo.Force("push", body["end"], (0, 0, -1e-3))
        tip = jo.PositionSensor("tip", body["end"])
        return jo.Mechanism(body, clamp, push, tip)

    given = [P("E", 2e11), P("width", 0.02)]
    study = jo.study(beam, given, ["first(tip.z)", "mass"], t_end=1e-3, state=jo.equilibrium)
    found = jo.design.gradient(study)
    assert found.exact, str(found)
    # F L^3 / (3 E I), and the shear, over width and E alike
    np.testing.assert_allclose(powers(found)[0], [-1.0, -1.0], rtol=1e-7)
    np.testing.assert_allclose(powers(found)[1], [0.0, 1.0], rtol=1e-9, atol=1e-12)
