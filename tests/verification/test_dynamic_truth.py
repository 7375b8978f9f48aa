"""Recovered stress against brute force: a clamped and a moving solid, component by component.

The truth is every degree of freedom of the mesh, stepped in inertial coordinates (`transients`).
The recovered stress is what a user gets: `reduce`, `simulate`, stress modes times coordinates. It
is wrong by three things, each of which is measured by refining it alone and nothing else:

* modes: few against nearly all of the deformation that the load can make;
* step: that of the solver against a 16th of it;
* second order: the strain of a modal body is linear in a frame that follows the body, in the mean
  (what `reduce` makes of one interface), whereas the truth is linear in the frame of its clamp. The
  two differ by products of deformations. Modes that leave the clamp where it is, spanning the
  same deformations, give the frame of the clamp.

That the budget is true means: the three add up to no less than the error found, for each of the
six components, and with all three refined nothing is left.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.linalg import eigh

import jousto as jo
from verification import bricks
from verification.boxes import block
from verification.solids import solid
from verification.transients import Mesh, extrapolated, newmark, still

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
LENGTH, AWAY = 0.3, 0.05  # m, the clamp is off the axis of rotation
AXIS = (0.3, -0.5, 0.8)
COMPONENTS = ("s11", "s22", "s33", "s12", "s23", "s13")


def bent(x):
    """A bar that narrows and turns aside: bending and torsion are coupled."""
    t = x[:, 0] / LENGTH
    y, z = x[:, 1] * (1.0 - 0.5 * t), x[:, 2] * (1.0 + 0.3 * t)
    return np.stack([AWAY + x[:, 0], y + 0.06 * t**2, z + 0.02 * t * y / 0.04], axis=1)


@dataclass(frozen=True)
class Case:
    """A pulse at the tip, and how far the clamp turns by the end."""

    t_end: float
    rise: float
    force: tuple[float, float, float]
    turn: float
    modes: int
    step: float  # of the solver
    fine: float  # of the brute force

    @property
    def pulse(self):
        return jo.SCurve([0.0, self.rise, 2.0 * self.rise], [0.0, 1.0, 0.0])

    @property
    def angle(self):
        return jo.SCurve([0.0, self.t_end], [0.0, self.turn])

    @property
    def times(self):
        return np.linspace(0.0, self.t_end, 41)[1:]


CLAMPED = Case(4e-3, 3e-4, (0.0, 400.0, 800.0), 0.0, 6, 1e-5, 5e-6)
MOVING = Case(4e-2, 2e-3, (0.0, 20.0, 40.0), 0.4, 6, 1e-4, 2e-5)
QUARTER = Case(8e-2, 2e-3, (0.0, 20.0, 40.0), 0.5 * np.pi, 12, 5e-5, 2e-5)
CASES = pytest.mark.parametrize("case", [CLAMPED, MOVING], ids=["clamped", "moving"])


class Bar:
    """The mesh, its own matrices and jousto's part."""

    def __init__(self, counts: tuple[int, int, int]) -> None:
        self.grid = block("hexahedron20", (LENGTH, 0.04, 0.02), counts, bend=bent)
        x = self.grid.nodes
        self.clamp = np.flatnonzero(x[:, 0] < AWAY + 1e-9)
        self.hit = int(np.argmax(x @ [1.0, 1.0, 1.0]))
        K, M = bricks.stiffness(self.grid, STEEL), bricks.mass(self.grid, STEEL)
        self.mesh = Mesh(M, K, x, self.clamp)
        tie = jo.Interface("clamp", self.clamp)
        self.part = solid(self.grid, STEEL, {"hit": [self.hit]}).with_interfaces(tie)

    def reduced(self, modes: int, clamped_frame: bool) -> jo.ReducedPart:
        """Fixed-interface modes and what they leave out of the response to the load."""
        unit = np.zeros((self.grid.nodes.size, 3))
        unit[3 * self.hit : 3 * self.hit + 3] = np.eye(3)
        mean = jo.reduce(self.part, jo.CraigBampton(modes=modes, residuals=(unit,)))
        if not clamped_frame:
            return mean
        # the same deformations seen from the clamp
        x = self.grid.nodes
        i, j, k = self.clamp[0], self.clamp[-1], self.clamp[len(self.clamp) // 2]
        X = mean.modes[: len(x)]
        rows = [np.r_[3 * i : 3 * i + 3], np.r_[3 * j : 3 * j + 3], np.r_[3 * k : 3 * k + 3]]
        rigid = np.zeros((len(x), 3, 6))
        rigid[:, :, :3] = np.eye(3)
        for a in range(3):
            rigid[:, :, 3 + a] = np.cross(np.eye(3)[a], x)
        rigid, at = rigid.reshape(-1, 6), np.concatenate(rows)
        flat = X.reshape(len(rigid), -1)
        flat = flat - rigid @ np.linalg.lstsq(rigid[at], flat[at])[0]
        square, turn = eigh(flat.T @ (self.mesh.K @ flat), flat.T @ (self.mesh.M @ flat))
        return jo.reduction.from_modes(self.part, flat @ turn, np.sqrt(square) / (2.0 * np.pi))

    def truth(self, case: Case) -> tuple[np.ndarray, np.ndarray]:
        """Stress (nt, ns, 6) of all nodes by brute force, and the same of its finest step."""

        def load(t: float) -> np.ndarray:
            f = np.zeros(self.grid.nodes.shape)
            f[self.hit] = np.array(case.force) * float(case.pulse(t))
            return f

        def angle(t: float) -> tuple[float, float, float]:
            value, rate, change = case.angle.jet(np.array(t))
            return float(value), float(rate), float(change)

        def run(h: float) -> np.ndarray:
            turn: Callable[[float], tuple[float, float, float]] = angle if case.turn else still
            u = newmark(self.mesh, load, h, case.times, axis=AXIS, angle=turn)
            return np.moveaxis(self.part.stress.evaluate(u.T), 2, 0)

        return extrapolated(run, case.fine)

    def recovered(self, case: Case, modes: int, step: float, clamped_frame: bool) -> np.ndarray:
        """Stress (nt, ns, 6) of all nodes from a run of jousto."""
        reduced = self.reduced(modes, clamped_frame)
        body = jo.FlexibleBody("bar", reduced)
        at = self.part.ties[0].at
        parts = [body, jo.Force("blow", body["hit"], case.force, signal=case.pulse)]
        if case.turn:
            hub = jo.RigidBody("hub", 1.0, (1.0, 1.0, 1.0))
            pivot = jo.Revolute("pivot", jo.ground["origin"], hub["origin"], axis=AXIS)
            parts += [hub, pivot, jo.Drive("turn", pivot.angle, case.angle)]
            parts.append(jo.Fixed("root", hub.at(at), body["clamp"]))
        else:
            parts.append(jo.Fixed("root", jo.ground.at(at), body["clamp"]))
        every = case.t_end / len(case.times)
        run = jo.simulate(
            jo.compile(jo.Mechanism(*parts)),
            case.t_end,
            solver=jo.ROS2(step=step),
            output_step=every,
        )
        assert np.allclose(run.time[1:], case.times)
        p = run.q[1:, 7 : 7 + reduced.n]
        assert reduced.stress is not None
        assert reduced.stress.labels == self.part.stress.sites
        return np.einsum("scj,tj->tsc", reduced.stress.modes, p)


@dataclass(frozen=True)
class Budget:
    """Of each component: the error, what it is made of, what is left with everything refined."""

    error: np.ndarray
    terms: dict[str, np.ndarray]
    left: np.ndarray


def apart(a, b, scale):
    """Largest difference of each component over all nodes and times, in shares of its largest."""
    return np.abs(a - b).max(axis=(0, 1)) / scale


def budget(part: Bar, case: Case, many: int) -> Budget:
    """Return the budget of a case, whose modes are refined to `many`; and print it."""
    truth, finest = part.truth(case)
    scale = np.abs(truth).max(axis=(0, 1))
    short = case.step / 16
    plain = part.recovered(case, case.modes, case.step, False)
    fine = part.recovered(case, case.modes, short, False)
    terms = {
        "modes": apart(fine, part.recovered(case, many, short, False), scale),
        "step": apart(plain, fine, scale),
        "second order": apart(fine, part.recovered(case, case.modes, short, True), scale),
        "truth": apart(finest, truth, scale),
    }
    left = apart(part.recovered(case, many, short, True), truth, scale)
    error = apart(plain, truth, scale)
    print(f"\n{'share of the largest':22}" + "".join(f"{c:>9}" for c in COMPONENTS))
    for name, row in {"MPa": scale / 1e6, "error": error, **terms}.items():
        print(f"{name:22}" + "".join(f"{x:9.2g}" for x in row))
    print(f"{'sum':22}" + "".join(f"{x:9.2g}" for x in sum(terms.values())))
    print(f"{'left, all refined':22}" + "".join(f"{x:9.2g}" for x in left))
    return Budget(error, terms, left)


def check(found: Budget) -> None:
    total = sum(found.terms.values())
    assert np.all(found.error <= 1.02 * total), found
    # and it is no wild guess: a good part of it is there
    assert np.all(found.error >= 0.25 * total), found
    # nothing else is in the error: modes, step and frame refined, the truth's own error is left
    assert np.all(found.left < 1e-3 + found.terms["truth"]), found
    assert np.all(found.left < 0.1 * found.error), found


@CASES
def test_the_error_budget_of_recovered_stress_is_true(case):
    check(budget(Bar((6, 1, 1)), case, 24))


@pytest.mark.slow
def test_the_error_budget_of_a_finer_bar_that_turns_a_quarter():
    check(budget(Bar((12, 2, 2)), QUARTER, 48))
