"""Exact beams beside modal bodies, among rigid bodies, and in the large against rigid links.

No published numbers: two theories of the same beam must agree where both hold. The modal body is
linear in its floating frame: one suffices for small deflections, bodies in series for large ones.
`beams_dynamic.Links` is Hencky's chain of rigid links, without any approximation of angles.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.beams_dynamic import Links
from verification.particles import rotation

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")
STRIP = jo.Rectangle(0.02, 0.002)
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
L, O = 0.8, jo.ground["origin"]
# wide side along y: it bends in x, z
FORCE = jo.Table((0.0, 0.05, 0.1, 0.5), (0.0, 1.0, 0.0, 0.0), "linear")


def exact(elements, force, **options):
    beam = jo.BeamBody("beam", [(0, 0, 0), (L, 0, 0)], STRIP, STEEL, elements=elements, **options)
    return jo.Mechanism(
        beam,
        jo.Fixed("wall", O, beam["start"]),
        jo.Force("push", beam["end"], (0, 0, force), signal=FORCE),
        jo.PositionSensor("tip", beam["end"]),
    )


def modal(pieces, force, modes=6):
    """The same beam as modal bodies in series."""
    ends = ("start", "end")
    part = jo.Part.beam(L / pieces, STRIP, 24 // pieces, STEEL, theory=jo.parts.Timoshenko())
    reduced = jo.reduce(part, jo.CraigBampton(ends, modes=modes))
    bodies = [
        jo.FlexibleBody(f"piece {k + 1}", reduced, position=(k * L / pieces, 0, 0))
        for k in range(pieces)
    ]
    welds = [
        jo.Fixed(f"weld {k}", a["end"], b["start"])
        for k, (a, b) in enumerate(zip(bodies, bodies[1:], strict=False), 1)
    ]
    tip = bodies[-1]["end"]
    return jo.Mechanism(
        *bodies,
        *welds,
        jo.Fixed("wall", O, bodies[0]["start"]),
        jo.Force("push", tip, (0, 0, force), signal=FORCE),
        jo.PositionSensor("tip", tip),
    )


def tip(mechanism, t_end=0.3, step=5e-4):
    solver = jo.GeneralizedAlpha(step=step, rho=0.7)
    run = jo.simulate(jo.compile(mechanism), t_end, solver=solver)
    return run["tip"]


def test_small_deflections_are_those_of_a_modal_body():
    force = 1e-3
    other = tip(modal(1, force))[:, 2]
    size = np.abs(other).max()
    assert size < 1e-3 * L
    misses = [
        np.abs(tip(exact(n, force, mass=0.5))[:, 2] - other).max() / size for n in (6, 12, 24)
    ]
    assert misses[0] > 3 * misses[1] > 9 * misses[2], misses
    assert misses[2] < 5e-3, misses


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*bends by .* within itself")
def test_large_deflections_are_those_of_modal_bodies_in_series():
    force = 9.0  # the tip swings by a quarter of the length and more
    best = tip(exact(48, force, mass=0.5))
    size = np.abs(best[:, 2]).max()
    assert size > 0.25 * L
    coarse = tip(exact(24, force, mass=0.5))
    assert np.abs(coarse - best).max() < 0.01 * size
    misses = [np.abs(tip(modal(pieces, force, modes=4)) - best).max() for pieces in (1, 2, 4, 8)]
    # one linear body is wrong by much, the difference falls with the number of bodies
    assert misses[0] > 2 * misses[1] > 4 * misses[2] > 8 * misses[3] * 0.9, misses
    assert misses[3] < 0.01 * size, misses


# -- a beam that swings far ------------------------------------------------------------------------

ROPE = {"EI": 0.5, "mass": 1.0, "length": 1.0}


def swinging(elements, clamped, **options):
    EI, m = ROPE["EI"], ROPE["mass"]
    # so stiff against stretch and shear that the links' theory holds to 1e-4
    section = jo.mechanism.BeamSection(
        np.diag([2e5, 2e5, 2e5, EI, 2 * EI, EI]), m, 1e-6 * np.diag([2.0, 1, 1])
    )
    beam = jo.BeamBody("rope", [(0, 0, 0), (1, 0, 0)], section, elements=elements, **options)
    kind = jo.Fixed if clamped else jo.Revolute
    axis = {} if clamped else {"axis": (0, 0, 1)}
    return jo.Mechanism(
        beam,
        kind("hold", O, beam["start"], **axis),
        jo.Gravity((0, -9.81, 0)),
        jo.PositionSensor("tip", beam["end"]),
    )


def links_tip(clamped, times):
    coarse, fine = (
        (k := Links(n, **ROPE, rotary=1e-6, clamped=clamped)).tip(times, k.weight(9.81))
        for n in (10, 20)
    )
    return fine + (fine - coarse) / 3


@pytest.mark.filterwarnings("ignore:.*which is coarse")
@pytest.mark.parametrize(
    "clamped", [pytest.param(True, marks=pytest.mark.slow), False], ids=["cantilever", "pendulum"]
)
def test_it_swings_far_as_a_chain_of_rigid_links_does(clamped):
    times = np.linspace(0, 0.8, 81)
    reference = links_tip(clamped, times)
    assert np.abs(reference[:, 1]).max() > 0.7
    misses = []
    for n, step in ((8, 4e-3), (16, 2e-3)):
        model = jo.compile(swinging(n, clamped, mass=0.5))
        solver = jo.GeneralizedAlpha(step=step, rho=0.7)
        run = jo.simulate(model, 0.8, solver=solver, output_step=0.02)
        misses.append(np.abs(run["tip"][:, :2] - reference[::2]).max())
    assert misses[1] < 8e-3, misses
    assert misses[0] > 2.5 * misses[1], misses


# -- every joint between a beam and the other bodies -----------------------------------------------

JOINTS = {
    "fixed": lambda a, b: jo.Fixed("joint", a, b),
    "revolute": lambda a, b: jo.Revolute("joint", a, b, axis=(0, 1, 0)),
    "spherical": lambda a, b: jo.Spherical("joint", a, b),
    "universal": lambda a, b: jo.Universal("joint", a, b, axis_a=(0, 1, 0), axis_b=(0, 0, 1)),
    "cylindrical": lambda a, b: jo.Cylindrical("joint", a, b, axis=(1, 0, 0)),
    "prismatic": lambda a, b: jo.Prismatic("joint", a, b, axis=(0, 0, 1)),
    "screw": lambda a, b: jo.Screw("joint", a, b, axis=(1, 0, 0), pitch=0.05),
    "planar": lambda a, b: jo.Planar("joint", a, b, normal=(0, 0, 1)),
    "orientation": lambda a, b: jo.ConstantOrientation("joint", a, b),
    "line": lambda a, b: jo.PointOnLine("joint", a, b, axis=(1, 0, 0)),
    "plane": lambda a, b: jo.PointOnPlane("joint", a, b, normal=(0, 0, 1)),
    "bushing": lambda a, b: jo.Bushing("joint", a, b, stiffness=(1e4,) * 3 + (1e2,) * 3),
}
RUBBER = jo.mechanism.BeamSection(
    np.diag([2e4, 8e3, 8e3, 6.0, 8.0, 8.0]), 1.5, 1e-3 * np.diag([2.0, 1, 1])
)
# energy of every node and of the modal body too: the beam meets it at one end, a block at the other
BLOCK = {"mass": 2.0, "inertia": (0.02, 0.03, 0.04)}


def train(joint):
    part = jo.Part.beam(0.5, jo.Rectangle(0.03, 0.02), 4, jo.Material(E=2e9, nu=0.3, rho=1200.0))
    rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    spin = {"angular_velocity": (0.5, 1.0, 3.0)}

    def moving(x):
        return {"position": (x, 0, 0), "velocity": np.cross((0.5, 1.0, 3.0), (x, 0, 0)), **spin}

    block = jo.RigidBody("block", **BLOCK, **moving(0.0))
    beam = jo.BeamBody("beam", [(0, 0, 0), (1, 0, 0)], RUBBER, elements=6, mass=0.5, **moving(0.0))
    flexible = jo.FlexibleBody("rod", rod, **moving(1.0))
    first = JOINTS[joint](block["origin"], beam["start"])
    second = jo.Spherical("end", beam["end"], flexible["start"])
    return block, beam, flexible, jo.Mechanism(block, beam, flexible, first, second)


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
@pytest.mark.parametrize("joint", JOINTS)
def test_every_joint_takes_beams_and_conserves_energy_and_momentum(joint):
    *_, mechanism = train(joint)
    model = jo.compile(mechanism)
    errors, momenta = [], []
    for step in (2e-3, 1e-3):
        run = jo.simulate(
            model, 0.2, solver=jo.GeneralizedAlpha(step=step, rho=1.0, tolerance=1e-12)
        )
        errors.append(np.abs(run.energy.error).max() / run.energy.total[0])
        momenta.append(momentum(model, run))
        assert run.residuals.position.max() < 1e-9
        assert run.residuals.velocity.max() < 1e-8
    # no outside force: the centre of mass moves on, whatever the joint and the beam do inside
    # (that of the modal body is a product of coordinates, constant to the order of the method)
    drift = [np.abs(P - P[0]).max() / np.abs(P[0]).max() for P in momenta]
    assert drift[1] < 1e-5, drift
    assert np.log2(drift[0] / drift[1]) > 1.5 or drift[1] < 1e-9, drift
    assert errors[1] < 5e-3, errors
    assert np.log2(errors[0] / errors[1]) > 1.5 or errors[1] < 1e-8, errors


def momentum(model, run):
    """Linear momentum (nt, 3): ``m R' + A (w x (S0 + I3 p) + I3 p')`` of every body.

    The shares of the consistent mass sum up to nothing.
    """
    total = np.zeros((len(run.time), 3))
    for body in model.bodies:
        n = body.I3.shape[1]
        q = run.q[:, body.iq : body.iq + 7 + n]
        v = run.v[:, body.iv : body.iv + 6 + n]
        local = np.cross(v[:, 3:6], body.S0 + q[:, 7:] @ body.I3.T) + v[:, 6:] @ body.I3.T
        A = np.array([rotation(e) for e in q[:, 3:7]])
        total += body.mass * v[:, :3] + np.einsum("tij,tj->ti", A, local)
    return total
