"""Loads of a run continue in CalculiX: a spinning bar of solids with its loads as a load step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

import jousto as jo
from jousto.mechanism.bodies.rigid_equivalent import rigid_body
from jousto.recovery.loads.nodal_forces import nodal_forces
from verification import calculix
from verification.boxes import block
from verification.solids import solid

Array = NDArray[np.float64]
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
L, W, H = 0.6, 0.04, 0.03
DIGITS = 2e-6
"""ccx prints seven digits of displacements."""

pytestmark = pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")


def bar(kind: str, interface: str) -> jo.Part:
    """Return a bar along x with an interface at its root."""
    part = solid(block(kind, (L, W, H), (12, 1, 1)), STEEL)
    root = np.flatnonzero(part.nodes[:, 0] < 1e-9)
    tip = np.flatnonzero(part.nodes[:, 0] > L - 1e-9)
    part = replace(part, name="bar", node_sets={"tip": (int(tip[0]),)})
    return part.with_interfaces(jo.Interface("root", root, kind=interface))


def spun(part: jo.Part, speed: float, *, rigid: bool = False, share: float = 1.0) -> jo.Solution:
    """Return a run of the bar that spins about z, with weight and a force at a node of its tip."""
    reduced = jo.reduce(part, jo.CraigBampton(("root", "tip"), modes=6), residual_stress=True)
    body = jo.FlexibleBody("arm", reduced, angular_velocity=(0, 0, speed))
    at = tuple(body["root"].position_local)
    hub = jo.ground.at(at)
    if rigid:
        stiff = rigid_body(body)
        turning = jo.Revolute("hub", hub, stiff.at(at), axis=(0, 0, 1))
        model = jo.compile(jo.Mechanism(stiff, turning))
        return jo.simulate(model, 0.02, output_step=1e-3)
    turning = jo.Revolute("hub", hub, body["root"], axis=(0, 0, 1))
    tug = jo.Force("tug", body["tip"], (0.0, 300.0 * share, 500.0 * share))
    model = jo.compile(jo.Mechanism(body, turning, tug, jo.Gravity((0, 0, -9.81 * share))))
    return jo.simulate(model, 0.02, output_step=1e-3, solver=jo.RK4(2e-6))


def displaced_by_ccx(loads: jo.recovery.BodyLoads, part: jo.Part, path: Path, t: float) -> Array:
    """Return the displacements (nn, 3) that ccx finds for the written deck."""
    jo.write(loads, path, part, times=[t])
    lines = path.read_text(encoding="utf-8").splitlines()
    end = lines.index("*END STEP")
    lines[end:end] = ["*NODE PRINT, NSET=NALL", "U"]
    return calculix.displacements(calculix.run(lines, ("dat",))["dat"], len(part.nodes))


@calculix.needed
@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20"])
def test_calculix_stretches_a_spinning_bar(kind: str, tmp_path: Path) -> None:
    """Statics of ccx and of the part agree; sections bear rho w^2 (L^2 - x^2)/2."""
    part = bar(kind, "average")
    loads = jo.recovery.loads_of(spun(part, 60.0, rigid=True), "arm")
    t = float(loads.time[-1])
    u = displaced_by_ccx(loads, part, tmp_path / "bar.inp", t)
    deck = nodal_forces(loads, part, [t])
    free = np.setdiff1d(np.arange(part.K.shape[0]), deck.held)
    own = np.zeros(part.K.shape[0])
    own[free] = spsolve(sp.csc_array(part.K)[free][:, free], deck.forces[0].ravel()[free])
    assert np.abs(u.ravel() - own).max() < DIGITS * np.abs(own).max()
    # the six supports bear nothing
    bears = (part.K @ own - deck.forces[0].ravel())[deck.held]
    assert np.abs(bears).max() < 1e-7 * np.abs(deck.forces).max()
    # mean stretch of the line of centres from root to tip: rho w^2 L^3 / 3E
    x = part.nodes[:, 0]
    ends = [u[np.abs(x - a) < 1e-9, 0].mean() for a in (0.25 * L, 0.75 * L)]
    a, b = 0.25 * L, 0.75 * L
    w = np.linalg.norm(loads.motion.w[-1])
    exact = 7850.0 * w**2 / (2 * STEEL.E) * (L**2 * (b - a) - (b**3 - a**3) / 3)
    assert ends[1] - ends[0] == pytest.approx(exact, rel=2e-3)


@calculix.needed
@pytest.mark.parametrize("speed, digits", [(60.0, 5e-3), (0.6, 5e-4)])
def test_calculix_finds_the_stress_of_the_run(speed: float, digits: float, tmp_path: Path) -> None:
    """A force and its weight shake the bar on its rigid root: the stress is that of the run.

    Mode acceleration leaves out Coriolis forces, in proportion to the speed; the deck has them.
    What remains is of second order: the bar bends by 1e-3 of its length.
    """
    part = bar("tetra10", "rigid")
    run = spun(part, speed)
    loads = jo.recovery.loads_of(run, "arm")
    t = float(loads.time[12])
    u = displaced_by_ccx(loads, part, tmp_path / "bar.inp", t)
    field = jo.stress_field(run, "arm", residual=run.model, times=[t], frame="body")
    assert part.stress is not None
    places = [part.stress.index(label) for label in field.labels]
    stress = part.stress.evaluate(u.ravel())[places]
    components = ("s11", "s22", "s33", "s12", "s23", "s13")
    own = np.stack([field.values(name)[0] for name in components], axis=1)
    assert np.abs(own).max() > 1e7
    assert np.abs(stress - own).max() < digits * np.abs(own).max()


def test_nodal_forces_have_those_of_coriolis() -> None:
    """Rates p' of the modes alone make -M 2 w x Phi p', less the resultant that M R carries."""
    part = bar("tetra10", "rigid")
    loads = jo.recovery.loads_of(spun(part, 60.0), "arm")
    motion, nn = loads.motion, len(part.nodes)
    still = replace(loads, motion=replace(motion, dp=np.zeros_like(motion.dp)))
    found = nodal_forces(loads, part).forces - nodal_forces(still, part).forces
    u = np.einsum("nij,tj->tni", loads.modes[:nn], motion.dp)
    own = -2.0 * np.cross(motion.w[:, None], u).reshape(len(u), -1) @ part.M
    R = part.rigid_modes()
    own -= own @ R @ np.linalg.solve(R.T @ (part.M @ R), (part.M @ R).T)
    assert np.abs(own).max() > 1e-3
    assert np.abs(found.reshape(own.shape) - own).max() < 1e-9 * np.abs(own).max()


@pytest.mark.parametrize("interface", ["rigid", "average"])
def test_nodal_forces_deform_a_part_as_in_the_run(interface: str) -> None:
    """``Phi^T f = K p`` for every mode and instant, but for terms of second order; f in balance."""
    part, errors = bar("tetra10", interface), []
    for share in (1.0, 0.01):
        loads = jo.recovery.loads_of(spun(part, 0.6, share=share), "arm")
        found = nodal_forces(loads, part)
        f = found.forces.reshape(len(found.time), -1)
        elastic = f @ loads.modes[: len(part.nodes)].reshape(f.shape[1], -1)
        needed = -loads["elastic"].modal
        errors.append(np.abs(elastic - needed).max() / np.abs(needed).max())
        assert np.abs(f @ part.rigid_modes()).max() < 1e-9 * np.abs(f).sum(axis=1).max()
    assert errors[0] < 5e-4 and errors[1] < 0.02 * errors[0]
