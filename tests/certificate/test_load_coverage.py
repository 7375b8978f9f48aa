"""Loads that the modes of a body leave out: the share of their static work, by closed forms."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo
from jousto.certificate.load_coverage import Reach

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
LENGTH, NODES = 1.0, 21
PART = jo.Part.beam(
    LENGTH, jo.Rectangle(0.02, 0.01), NODES - 1, STEEL, theory=jo.parts.EulerBernoulli()
)


def pattern(axis: int = 2) -> np.ndarray:
    """A line load of 1 N/m between the ends."""
    F = np.zeros((NODES, 3))
    F[1:-1, axis] = LENGTH / (NODES - 1)
    return F


def loads() -> np.ndarray:
    F = np.zeros((NODES, 6))
    F[:, :3] = pattern()
    return F.ravel()


def run(machine: jo.Mechanism) -> jo.Solution:
    """Run long enough to be warned."""
    return jo.simulate(jo.compile(machine), 1e-6, solver=jo.RK4(1e-6))


def told(method: object, *more: object, item: object = None, part: jo.Part = PART) -> list[str]:
    body = jo.FlexibleBody("beam", jo.reduce(part, method))  # type: ignore[arg-type]
    load = jo.mechanism.ModalLoad("wind", body, pattern()) if item is None else item(body)  # type: ignore[operator]
    weld = jo.Fixed("weld", jo.ground["origin"], body["start"])
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run(jo.Mechanism(body, weld, load))
    return [str(w.message) for w in found if "static work" in str(w.message)]


def test_a_pattern_that_no_mode_holds_is_told_with_its_share() -> None:
    # both ends held, no mode between them: all of the work is left out
    (message,) = told(jo.CraigBampton(("start", "end"), modes=0))
    assert "ModalLoad 'wind'" in message and "leave out 100 %" in message
    assert "more modes" in message and "residuals" in message and "interface" in message


def test_the_share_is_that_of_the_clamped_beam() -> None:
    # a line load q on clamped ends works q^2 L^5 / 720 EI, in the first mode of mean value
    # 4 sigma / a only (4 sigma / a)^2 q^2 L^5 / a^4 EI (Blevins 1979, table 8-1): 0.7 % less
    a, sigma = 4.7300407449, 0.9825022146
    work = Reach(jo.reduce(PART, jo.CraigBampton(("start", "end"), modes=2))).work(loads()[:, None])
    assert work is not None
    left = 1.0 - 720.0 * (4.0 * sigma / a) ** 2 / a**4
    # of 19 forces instead of a line
    assert 1.0 - work[1] / work[0] == pytest.approx(left, rel=0.02)


@pytest.mark.parametrize(
    "method",
    [
        jo.CraigBampton(("start", "end"), modes=12),
        jo.CraigBampton(("start", "end"), modes=0, residuals=(loads(),)),
        jo.FreeFree(modes=4, residuals=(loads(),)),
    ],
    ids=["modes", "residual", "free"],
)
def test_modes_that_hold_the_load_are_left_alone(method: object) -> None:
    assert not told(method)


def test_a_force_between_the_interfaces_is_told() -> None:
    def push(body: jo.FlexibleBody) -> jo.Force:
        return jo.Force("push", body["node11"], (0.0, 0.0, 1.0))

    (message,) = told(jo.CraigBampton(("start", "end"), modes=0), item=push)
    assert "Force 'push'" in message and "at node11" in message
    assert not told(jo.CraigBampton(("start", "end"), modes=12), item=push)


def test_a_force_on_an_interface_needs_no_mode() -> None:
    def pull(body: jo.FlexibleBody) -> jo.Force:
        return jo.Force("pull", body["end"], (0.0, 0.0, 1.0))

    assert not told(jo.CraigBampton(("start", "end"), modes=0), item=pull)


def test_weight_that_no_mode_holds_is_told() -> None:
    def weight(body: jo.FlexibleBody) -> jo.Gravity:
        return jo.Gravity((0.0, 0.0, -9.81))

    (message,) = told(jo.CraigBampton(("start", "end"), modes=0), item=weight)
    assert "body 'beam'" in message and "its weight" in message
    # clamped at both ends, its mode holds 99.3 % of the work
    assert not told(jo.CraigBampton(("start", "end"), modes=2), item=weight)
    relief = jo.CraigBampton(("start", "end"), modes=0, inertia_relief=True)
    assert not told(relief, item=weight)


def test_stress_is_as_wrong_as_the_warning_says() -> None:
    # forces F at x: F x at the root of a cantilever, of which modes without the load's response
    # lack the moment of clamped ends, F x (L - x)^2 / L^2
    def root(method: object) -> float:
        reduced = jo.reduce(PART, method)  # type: ignore[arg-type]
        body = jo.FlexibleBody("beam", reduced)
        model = jo.compile(
            jo.Mechanism(
                body,
                jo.Fixed("weld", jo.ground["origin"], body["start"]),
                jo.mechanism.ModalLoad("wind", body, pattern()),
            )
        )
        p = jo.equilibrium(model).q[7:]
        assert reduced.stress is not None
        return float(np.abs(reduced.stress.modes[:, 0] @ p).max())

    section_modulus = 0.02 * 0.01**2 / 6.0
    x, F = np.linspace(0.0, LENGTH, NODES), pattern()[:, 2]
    exact, clamped = F @ x, F @ (x * (LENGTH - x) ** 2) / LENGTH**2
    with pytest.warns(jo.JoustoWarning, match="100 % of the static work of pattern 'wind'"):
        found = root(jo.CraigBampton(("start", "end"), modes=0))
    assert found == pytest.approx((exact - clamped) / section_modulus, rel=1e-6)
    found = root(jo.CraigBampton(("start", "end"), modes=0, residuals=(loads(),)))
    assert found == pytest.approx(exact / section_modulus, rel=1e-6)


def test_modes_of_a_clamped_part_are_asked_too() -> None:
    # its interface rests in every mode; three modes of each plane leave out less than 1 % of a line
    # load on a cantilever, none of the plane leaves out all
    reduced = jo.reduction.clamp(jo.reduce(PART, jo.CraigBampton(("start",), modes=6)), "start")
    body = jo.FlexibleBody("beam", reduced)
    weld = jo.Fixed("weld", jo.ground["origin"], body["start"])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(jo.Mechanism(body, weld, jo.mechanism.ModalLoad("wind", body, pattern())))
    flat = reduced.keep(reduced.in_plane("xy"))
    work = Reach(flat).work(loads()[:, None])
    assert work is not None and work[1][0] < 1e-9 * work[0][0]
    assert Reach(reduced).work(loads()[:, None])[1][0] > 0.98 * work[0][0]  # type: ignore[index]


def test_compile_solves_no_full_model_and_a_run_no_large_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from jousto.certificate import load_warnings

    part = jo.Part.beam(LENGTH, jo.Rectangle(0.02, 0.01), NODES - 1, STEEL)  # nobody asked it yet
    body = jo.FlexibleBody("beam", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=0)))
    weld = jo.Fixed("weld", jo.ground["origin"], body["start"])
    machine = jo.Mechanism(body, weld, jo.mechanism.ModalLoad("wind", body, pattern()))
    monkeypatch.setattr(Reach, "__init__", lambda *_: pytest.fail("solved the full model"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.compile(machine)
        monkeypatch.setattr(load_warnings, "RUN_SIZE", 6 * NODES - 1)
        run(machine)
    monkeypatch.undo()
    assert any("leave out 100 %" in text for text in jo.doctor(machine).warnings)


def test_the_full_model_is_factorised_once_for_all_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    part = jo.Part.beam(LENGTH, jo.Rectangle(0.02, 0.01), NODES - 1, STEEL)  # nobody asked it yet
    body = jo.FlexibleBody("beam", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=8)))
    weld = jo.Fixed("weld", jo.ground["origin"], body["start"])
    winds = [jo.mechanism.ModalLoad(f"wind {k}", body, pattern(k)) for k in (1, 2)]
    made: list[object] = []
    init = Reach.__init__

    def counted(self: Reach, reduced: jo.ReducedPart) -> None:
        made.append(reduced)
        init(self, reduced)

    monkeypatch.setattr(Reach, "__init__", counted)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        run(jo.Mechanism(body, weld, *winds))
    assert len(made) == 1


def midspan(modes: int) -> tuple[jo.Mechanism, float, float]:
    """A beam between its ends with a force in the middle; how wrong work and stress are."""
    body = jo.FlexibleBody("beam", jo.reduce(PART, jo.CraigBampton(("start", "end"), modes=modes)))
    weld = jo.Fixed("weld", jo.ground["origin"], body["start"])
    push = jo.Force("push", body["node11"], (0.0, 0.0, 1.0))
    # of a force that may turn, the three directions together
    whole, held = Reach(body.reduced).work(np.eye(6 * NODES)[:, 60:63])  # type: ignore[misc]
    left = float(1.0 - held.sum() / whole.sum())
    return jo.Mechanism(body, weld, push), left, left**0.5


def test_doctor_tells_the_error_of_stress_from_two_percent() -> None:
    # the modes are the best displacements they can be (Ritz), so that |s - s_r|^2 = |s|^2 - |s_r|^2
    machine, left, stress = midspan(10)
    assert 4e-4 < left < 1e-2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run(machine)
    (message,) = [text for text in jo.doctor(machine).warnings if "static work" in text]
    assert f"leave out {100 * left:.2g} % of the static work" in message
    assert f"the error of its stress is {100 * stress:.2g} % (energy norm)" in message
