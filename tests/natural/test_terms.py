"""verify on machines that excite what the examples hardly do, and with terms that are missing.

The faults stand in the second formulation here; the same in the engine are found as well.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.arrays import Array
from jousto.natural.equations import coordinates, force_laws, frames, friction
from jousto.natural.equations.bodies import FRAME, Bodies
from jousto.natural.verification import Verification
from jousto.natural.verify import verify
from natural.terms import TERMS

Patch = pytest.MonkeyPatch
Plant = Callable[[Patch], None]
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def found(mechanism: jo.Mechanism) -> Verification:
    return verify(mechanism, 0.01, step=5e-4)


@pytest.mark.parametrize("core", ["auto", "maximal"])
@pytest.mark.parametrize("name", TERMS)
def test_they_agree(name: str, core: str) -> None:
    """1e-7: a tenth of what verify allows, and ten times what rounding of reactions leaves."""
    result = found(TERMS[name](core))
    assert result.agrees, result
    assert all(row.at_instants < 1e-7 for row in result.rows if not np.isnan(row.at_instants))


def no_coriolis(patch: Patch) -> None:
    """Products of an axis and a line or an axis lack ``2 P' . Q'``."""

    def second(self: Any, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        (P, Q), _, (ddP, ddQ) = (self._factors(*y) for y in zip(a, b, strict=True))
        sliding = self.line[:, 0]
        (dP, dQ) = self._factors(a[1], b[1])
        mixed = np.where(sliding, 0.0, 2.0 * np.sum(dP * dQ, axis=1))
        return np.asarray(np.sum(ddP * Q + P * ddQ, axis=1) + mixed)

    patch.setattr(coordinates.Products, "second", second)


def round_bodies(patch: Patch) -> None:
    """Products of inertia of rigid bodies are those of a ball, so that nothing precesses."""
    made = Bodies.of.__func__  # type: ignore[attr-defined]

    def of(cls: type[Bodies], bodies: Any) -> Bodies:
        out: Bodies = made(cls, bodies)
        out.second[:] = np.trace(out.second, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
        return out

    patch.setattr(Bodies, "of", classmethod(of))


def stiff_nodes(patch: Patch) -> None:
    """Markers at flexible nodes do not turn with the modes."""
    place = frames.Frames.close

    def close(self: frames.Frames) -> None:
        self._found = [(b, u0, A0, Phi, 0.0 * Psi) for b, u0, A0, Phi, Psi in self._found]
        place(self)

    patch.setattr(frames.Frames, "close", close)


def lost_modes(patch: Patch) -> None:
    """Coriolis forces of the modes on the frame are half as large."""
    whole = Bodies.loads

    def loads(self: Bodies, shape: Any, v: Array, gravity: Array) -> Array:
        Q = whole(self, shape, v, gravity)
        still = v.reshape(len(Q), -1).copy()
        still[:, FRAME:] = 0.0
        Q[:, :FRAME] = 0.5 * (Q + whole(self, shape, still.ravel(), gravity))[:, :FRAME]
        return Q

    patch.setattr(Bodies, "loads", loads)


def no_moment(patch: Patch) -> None:
    """A bushing acts on the first body at its marker, without the moment of the distance."""
    whole = force_laws.relative

    def relative(a: Array, b: Array) -> tuple[Array, Array, Array]:
        x, ga, gb = whole(a, b)
        for k in range(3):
            ga[k, 1 + k] = 0.0
        return x, ga, gb

    patch.setattr(force_laws, "relative", relative)


def pushing(patch: Patch) -> None:
    """Friction pushes instead of holding."""
    whole = friction.friction_law

    def rubbing(given: Any, *rest: Any) -> Any:
        law = whole(given, *rest)

        def apply(now: Any, out: Any) -> None:
            before = out.along.copy()
            law(now, out)
            out.along[:] = 2.0 * before - out.along

        return apply

    patch.setattr("jousto.natural.equations.system.friction_law", rubbing)


@dataclass(frozen=True)
class Fault:
    """A machine, what is wrong with the second formulation of it, and what shows it."""

    machine: str
    plant: Plant
    shown: tuple[str, ...]


FAULTS = {
    "Coriolis of a slide": Fault("rotating slides", no_coriolis, ("block", "nut", "slide")),
    "gyroscopic moment": Fault("gyroscope", round_bodies, ("rotor", "top", "ring", "bearing")),
    "rotation of a node": Fault("node frames", stiff_nodes, ("hold 1", "hold 2")),
    "Coriolis of modes": Fault("node frames", lost_modes, ("first", "second", "hand")),
    "moment of a bushing": Fault("offset bushings", no_moment, ("low", "foot", "link")),
    "sign of friction": Fault("reversing friction", pushing, ("block", "pendulum", "slides")),
}


@pytest.mark.parametrize("case", FAULTS)
def test_a_planted_fault_is_found_and_named(case: str, monkeypatch: Patch) -> None:
    fault = FAULTS[case]
    fault.plant(monkeypatch)
    result = found(TERMS[fault.machine]())
    assert result.word == "disagree", result
    named = [*result.open_joints, *(row.name for row in result.different)]
    assert any(word in name for name in named for word in fault.shown), result
    assert f"'{named[0]}'" in result.verdict


def test_friction_reverses() -> None:
    """Both joints rub in either direction within the run of the gallery."""
    run = jo.simulate(jo.compile(TERMS["reversing friction"]()), 0.3, output_step=1e-3)
    assert np.ptp(np.sign(np.diff(run["way"][:, 0]))) == 2.0
