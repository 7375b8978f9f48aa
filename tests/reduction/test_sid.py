"""Standard input data of other programs: particles with modes of any kind, written here by sums."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose

import jousto as jo

RNG = np.random.default_rng(5)
P, N = 9, 3  # particles, modes
MASS, PLACE = RNG.uniform(0.5, 2.0, P), RNG.normal(size=(P, 3))
PHI, PSI = 0.3 * RNG.normal(size=(P, 3, N)), RNG.normal(size=(P, 3, N))
ROOT = RNG.normal(size=(N, N))
K = 1e4 * (ROOT @ ROOT.T + np.eye(N))
SKEW = np.zeros((3, 3, 3))
for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    SKEW[a, b, c], SKEW[b, a, c] = -1.0, 1.0  # x~ = SKEW @ x


def matrices() -> dict[str, tuple[Any, Any]]:
    """M0 and M1 (rows, columns, coordinates) by sums over the particles."""
    m, s = MASS, np.einsum("acb,kbj->kjac", SKEW, PHI)
    u = np.einsum("acb,kb->kac", SKEW, PLACE)
    C3 = np.einsum("k,kaj->aj", m, PHI)
    Gr0 = 2 * np.einsum("k,kca,kjcb->ajb", m, u, s).reshape(3, -1)
    Gr1 = 2 * np.einsum("k,kica,kjcb->ajbi", m, s, s).reshape(3, -1, N)
    I8 = np.einsum("k,kca,kjcb->jab", m, u, s)
    return {
        "mdCM": ((m @ PLACE)[:, None], C3[:, None, :]),
        "J": (
            np.einsum("k,kca,kcb->ab", m, u, u),
            (I8 + I8.transpose(0, 2, 1)).transpose(1, 2, 0),
        ),
        "Ct": (C3.T, None),
        "Cr": (
            np.einsum("k,kab,kbj->ja", m, u, PHI),
            np.einsum("k,kjab,kbi->iaj", m, s, PHI),
        ),
        "Me": (np.einsum("k,kai,kaj->ij", m, PHI, PHI), None),
        "Gr": (Gr0, Gr1),
        "Ke": (K, None),
        "De": (2e-4 * K, None),
    }


def block(name: str, M0: Any, M1: Any, structure: int = 3) -> list[str]:
    rows, columns = M0.shape
    nq = 0 if M1 is None else M1.shape[2]
    head = (nq > 0, rows, columns, nq, 0, structure)
    names = ("order", "nrow", "ncol", "nq", "nqn", "structure")
    lines = [name, *(f"  {key} = {int(value)}" for key, value in zip(names, head, strict=True))]
    lines += [f"  m0( {i + 1}, {j + 1}) = {v:.17E}" for (i, j), v in np.ndenumerate(M0)]
    if M1 is not None:
        lines += [
            f"  m1( {i + 1}, {k + 1}, {j + 1}) = {v:.17E}".replace("E", "D")
            for (i, j, k), v in np.ndenumerate(M1)
        ]
    return [*lines, f"end {name}"]


def written(path: Path, changed: dict[str, tuple[Any, Any]] | None = None) -> Path:
    lines = [f"{P} {N}", "part", "new modal", "refmod", f"mass = {MASS.sum():.17E}"]
    lines += [f"nelastq = {N}", "ielastq ( 1) = bending", "end refmod", "frame"]
    for k in range(P):
        lines += [f"new node = {k + 11}", "rframe = body ref"]
        lines += block("origin", PLACE[k][:, None], PHI[k][:, None, :])
        lines += block("phi", PHI[k], None) + block("psi", PSI[k], None)
        lines += block("AP", np.eye(3), None, structure=4) + ["end node"]
    lines += ["end frame"]
    for name, (M0, M1) in (matrices() | (changed or {})).items():
        lines += block(name, M0, M1)
    path.write_text("\n".join([*lines, "end modal", "end part", ""]))
    return path


def test_modes_that_are_not_orthonormal_become_so(tmp_path: Path) -> None:
    part = jo.ReducedPart.load(written(tmp_path / "body.SID_FEM"))
    values, X = scipy.linalg.eigh(K, np.einsum("k,kai,kaj->ij", MASS, PHI, PHI))
    assert_allclose(part.frequencies, np.sqrt(values) / (2 * np.pi), rtol=1e-12)
    sign = np.sign(np.einsum("kaj,kaj->j", part.modes, PHI @ X))
    phi = PHI @ X * sign
    assert_allclose(part.modes, phi, rtol=1e-9, atol=1e-12)
    assert part.rotations is not None
    assert_allclose(part.rotations, PSI @ X * sign, rtol=1e-9, atol=1e-12)
    assert_allclose(part.nodes, PLACE, rtol=1e-15)
    inv = part.invariants
    assert_allclose(inv.I6, np.eye(N), atol=1e-12)
    outer = {
        "second_moment": np.einsum("k,ka,kb->ab", MASS, PLACE, PLACE),
        "I3": np.einsum("k,kaj->aj", MASS, phi),
        "N0": np.einsum("k,ka,kbj->jab", MASS, PLACE, phi),
        "E": np.einsum("k,kai,kbj->ijab", MASS, phi, phi),
    }
    for name, wanted in outer.items():
        assert_allclose(getattr(inv, name), wanted, atol=1e-11 * MASS.sum(), err_msg=name)
    assert part.node("node11") == 0 and part.node("node19") == 8
    ratios = [float(word) for word in part.provenance["damping ratios"].split(",")]
    assert_allclose(ratios, 1e-4 * np.sqrt(values), rtol=1e-5)  # De = 2e-4 Ke


def test_files_from_here_move_as_the_part_that_was_written(tmp_path: Path) -> None:
    blade = jo.Part.beam(1.0, jo.Rectangle(0.01, 0.03), 4, jo.Material(7e10, 0.3, 2700.0))
    method = jo.CraigBampton(interfaces=("start",), modes=3)
    part = jo.reduce(blade, method, stiffening=True)
    again = jo.ReducedPart.load(jo.write(part, tmp_path / "blade.sid"))
    assert again.node("start") == part.node("start")
    tips = []
    for one in (part, again):
        body = jo.FlexibleBody("blade", one, angular_velocity=(0.0, 40.0, 3.0))
        hub = jo.Revolute("hub", jo.ground["origin"], body["start"], axis=(0, 1, 0))
        turn = jo.Drive("turn", hub.angle, jo.ConstantSpeed(40.0))
        push = jo.Force("push", body["end"], (0, 30.0, 5.0))
        tip = jo.PositionSensor("tip", body["end"])
        machine = jo.Mechanism(body, hub, turn, push, tip)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", jo.JoustoWarning)
            model = jo.compile(machine)
        tips.append(jo.simulate(model, 0.1, solver=jo.RK4(1e-4))["tip"])
    assert np.ptp(tips[0][:, 1]) > 1e-3
    # sixteen digits in the file, 1000 steps
    assert_allclose(tips[1], tips[0], atol=1e-9)
    assert again.stiffening is not None and part.stiffening is not None
    size = np.abs(part.stiffening.second_moment).max()
    found = again.stiffening.second_moment
    assert_allclose(found, part.stiffening.second_moment, atol=1e-6 * size)


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    Gr0, _ = matrices()["Gr"]
    path = written(tmp_path / "first.sid", {"Gr": (Gr0, None)})
    with pytest.warns(jo.JoustoWarning, match="Gr is not of first order"):
        part = jo.ReducedPart.load(path)
    full = jo.ReducedPart.load(written(tmp_path / "full.sid"))
    for name in ("I3", "I4", "I5", "I6", "I8"):
        one, other = getattr(part.invariants, name), getattr(full.invariants, name)
        assert_allclose(one, other, atol=1e-10 * np.abs(other).max(), err_msg=name)
    Cr0, Cr1 = matrices()["Cr"]
    with pytest.warns(jo.JoustoWarning, match="Cr and Gr differ by "):
        jo.ReducedPart.load(written(tmp_path / "odd.sid", {"Cr": (1.1 * Cr0, Cr1)}))
    with pytest.warns(jo.JoustoWarning, match="ksigma: stiffness"):
        jo.ReducedPart.load(written(tmp_path / "k.sid", {"ksigma": (np.ones((N, 1)), None)}))


def test_files_that_are_wrong(tmp_path: Path) -> None:
    def problems(text: str) -> str:
        path = tmp_path / "wrong.sid"
        path.write_text(text)
        with pytest.raises(jo.InputError) as caught:
            jo.ReducedPart.load(path)
        return str(caught.value)

    good = written(tmp_path / "good.sid").read_text()
    assert "has no mdCM" in problems("nothing\nof the kind\n")
    assert "mass is -1 kg" in problems(good.replace(f"mass = {MASS.sum():.17E}", "mass = -1"))
    assert "must be a finite number" in problems(
        good.replace("m0( 1, 1) = ", "m0( 1, 1) = nan#", 1)
    )
    assert "wrong.sid:14: origin: nrow is" in problems(good.replace("nrow = 3", "nrow = three", 1))
    assert "which is beyond any valid size" in problems(
        good.replace("nrow = 3", "nrow = 999999999999", 1)
    )
    assert "is outside of 3 x 1" in problems(good.replace("m0( 1, 1)", "m0( 7, 1)", 1))
    assert "has 3 x 2 numbers, must have 3 x 1" in problems(
        good.replace("ncol = 1", "ncol = 2", 1).replace("m1( 1, 1, 1)", "m1( 1, 1, 2)", 1)
    )
    negative = written(tmp_path / "negative.sid", {"Ke": (-K, None)}).read_text()
    assert "Ke is not positive definite: 3 modes" in problems(negative)
    singular = written(tmp_path / "singular.sid", {"Me": (np.zeros((N, N)), None)}).read_text()
    assert "Me is not positive definite" in problems(singular)
    with pytest.raises(jo.InputError, match="there is no such file"):
        jo.ReducedPart.load(tmp_path / "none.sid")


def test_damaged_files_never_crash(tmp_path: Path) -> None:
    lines = written(tmp_path / "good.sid").read_text().splitlines()
    rng = np.random.default_rng(11)
    path = tmp_path / "damaged.sid"
    refused = 0
    for _ in range(120):
        some = list(lines)
        for _ in range(3):
            i = int(rng.integers(len(some)))
            kind = int(rng.integers(4))
            if kind == 0:
                del some[i]
            elif kind == 1:
                some[i] = some[i][: len(some[i]) // 2]
            elif kind == 2:
                some = some[: max(i, 2)]
            else:
                some[i] = some[i].replace("1", "99999")
        path.write_text("\n".join(some))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", jo.JoustoWarning)
            try:
                jo.ReducedPart.load(path)
            except jo.InputError:
                refused += 1
    assert refused > 40
