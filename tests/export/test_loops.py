"""Algebraic loops through units of other programs: an added mass that wants the acceleration."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from export.test_foreign import DESCRIPTION, pack
from exported import CC
from jousto.simulation.cosimulation.algebraic_loops import GROWTH, STEEP, Growth, Loop, LoopFailed

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

CART, PUSH, STEP = 2.0, 10.0, 1e-3  # kg, N, s


def added_mass(folder: Path, name: str, *flags: str, depends: str = "") -> Path:
    """Compile a unit whose force is -area a - bulk |a| a, a being its input "speed" in m/s2."""
    made = pack(folder, name, "-DMASS", *flags)
    text = DESCRIPTION.replace("{factor}", "1").replace('unit="mm/s"', 'unit="m/s2"')
    text = text.replace('<Unit name="mm/s"><BaseUnit m="1" s="-1" factor="1"/></Unit>',
                        '<Unit name="m/s2"><BaseUnit m="1" s="-2"/></Unit>')  # fmt: skip
    text = text.replace('unit="odd"', 'unit="kg"').replace('<Unit name="odd"/>', "")
    text = text.replace('<Unknown index="3"/>', f'<Unknown index="3" {depends}/>')
    out = folder / f"{name}_mass.fmu"
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(out, "w") as new:
        for key in old.namelist():
            content = old.read(key)
            new.writestr(key, text if key == "modelDescription.xml" else content)
    return out


@pytest.fixture(scope="module")
def unit(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return added_mass(tmp_path_factory.mktemp("mass"), "direct", depends='dependencies="1"')


def run(file: Path, mass: float, drag: float = 0.0, t_end: float = 0.1, **how: Any) -> jo.Solution:
    """Push a cart with an added mass on it."""
    body = jo.RigidBody("cart", CART, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    drive = jo.JointForce("drive", rail.displacement, PUSH)
    force = jo.JointForce("force", rail.displacement, jo.Input("added"))
    speed = jo.RateSensor("speed", rail.displacement)
    felt = jo.AccelerationSensor("felt", body["origin"])
    fmu = jo.Fmu(
        file,
        name="mass",
        inputs={"speed": (felt, 0)},
        outputs={"force": jo.Input("added")},
        parameters={"area": mass, "bulk": drag},
        step=STEP,
        **how,
    )
    mechanism = jo.Mechanism(body, rail, drive, force, speed, felt, fmu)
    return jo.simulate(jo.compile(mechanism), t_end, solver=jo.RK4(step=STEP))


@pytest.mark.parametrize("gain", (0.5, 1.5, 30.0))
def test_an_added_mass_accelerates_as_one_body(unit: Path, gain: float) -> None:
    """a = P / (M + m), constant, so that held values have no error but the loop's 1e-9."""
    found = run(unit, gain * CART)
    exact = PUSH * found.time / (CART * (1.0 + gain))
    # 1e-9 of the force of the unit, which cancels all but 1 / (1 + gain) of the push
    assert np.abs(found["speed"][:, 0] - exact).max() < 1e-9 * (1.0 + gain) * exact[-1]


def test_a_nonlinear_loop_is_solved_at_each_exchange(unit: Path) -> None:
    """(M + m) a + c a^2 = P has one positive root."""
    mass, drag = 3.0, 0.8
    found = run(unit, mass, drag)
    a = np.roots([drag, CART + mass, -PUSH]).max()
    assert np.abs(found["felt"][:, 0] - a).max() < 1e-7 * a
    assert np.abs(found["speed"][-1, 0] - a * found.time[-1]) < 1e-7


def test_the_result_is_the_same_where_the_description_names_no_dependencies(
    unit: Path, tmp_path: Path
) -> None:
    """The standard then lets outputs depend on every input."""
    other = run(added_mass(tmp_path, "silent"), 3.0)
    assert np.array_equal(other["speed"], run(unit, 3.0)["speed"])


def test_a_loop_that_answers_a_step_late_is_refused_with_its_gain(tmp_path: Path) -> None:
    """It iterates f <- -(m/M) f + ... once an exchange: nothing but another interface helps."""
    late = added_mass(tmp_path, "late", "-DLATE", depends='dependencies="1"')
    with pytest.raises(
        jo.simulation.RunFailed, match=r"fmu 'mass'.* factor of 1\.5 .*algebraic loop"
    ) as error:
        run(late, 1.5 * CART)
    assert error.value.solution is not None and np.isfinite(error.value.solution["speed"]).all()
    found = run(late, 0.5 * CART)  # converges within some exchanges
    exact = PUSH * found.time[-1] / (1.5 * CART)
    assert abs(found["speed"][-1, 0] - exact) < 0.05 * exact


def test_a_run_that_diverges_names_the_unit(tmp_path: Path) -> None:
    late = added_mass(tmp_path, "late", "-DLATE", depends='dependencies="1"')
    with pytest.raises(jo.simulation.RunFailed, match="fmu 'mass'"):
        run(late, 1e5 * CART)


def test_forces_that_cancel_are_closed_to_their_rounding() -> None:
    """A body at rest under 1e3 N has 1e-13 m/s2 by rounding: no solution is closer."""
    calls = []

    def answer(y: np.ndarray) -> np.ndarray:
        calls.append(y)
        return -1.5 * ((1e3 + 1e-13 + y) - 1e3)

    Loop().solve(np.zeros(1), answer)
    assert abs(answer(calls[-1])[0]) < 1e-12


def test_a_loop_without_a_solution_is_no_rounding() -> None:
    with pytest.raises(LoopFailed):
        Loop().solve(np.ones(1), lambda y: y + 1.0 + y**2)


def test_growth_of_a_smooth_start_is_no_loop() -> None:
    """Differences of t^n grow by ((k+1)/k)^(n-1), those of a loop by its gain."""
    for order in range(1, 7):
        growth = Growth()
        values = np.arange(60.0)[:, None] ** order
        for before, now in zip(values[:-1], values[1:], strict=True):
            growth.see(before, now)
            assert growth.gain == 0.0
    for ratio in (-1.1, 1.1 * STEEP):
        growth, x = Growth(), ratio ** np.arange(GROWTH + 2.0)[:, None]
        for before, now in zip(x[:-1], x[1:], strict=True):
            growth.see(before, now)
        assert growth.gain == pytest.approx(abs(ratio), rel=1e-9)
