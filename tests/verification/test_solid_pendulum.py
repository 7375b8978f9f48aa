"""The pendulum of solids against the pendulum of beams.

The bar of T. Rantalainen, *Rakenteellisen jouston kuvaus reaaliaikasimuloinnissa* (LUT 2007),
chapter 5: 2 m x 0.1 m x 0.1 m, 7850 kg/m3, hung at one end, let go at rest along x; with the
modulus of steel, E = 2.07e11 Pa.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import jousto as jo
from verification.boxes import block
from verification.solids import solid

LENGTH, SIDE = 2.0, 0.1
STEEL = 2.07e11  # Pa
G = 9.81


def bar(E):
    return jo.Material(E=E, nu=0.3, rho=7850.0)


@cache
def beams(E, modes):
    part = jo.Part.beam(LENGTH, jo.Rectangle(SIDE, SIDE), 16, bar(E))
    return (
        jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=modes)),
        "start",
        "node9",
        "end",
    )


@cache
def solids(E, modes, kind="average"):
    grid = block(
        "hexahedron20",
        (LENGTH, SIDE, SIDE),
        (16, 2, 2),
        bend=lambda x: x - np.array([0.0, SIDE / 2, SIDE / 2]),
    )
    middle = np.flatnonzero(np.linalg.norm(grid.nodes - [LENGTH / 2, 0, 0], axis=1) < 1e-9)
    tip = np.flatnonzero(np.linalg.norm(grid.nodes - [LENGTH, 0, 0], axis=1) < 1e-9)
    part = solid(grid, bar(E), sets={"middle": middle, "tip": tip})
    part = part.with_interfaces(jo.Interface("pivot", grid.plane(0, 0.0), kind, at=(0, 0, 0)))
    return jo.reduce(part, jo.CraigBampton(modes=modes)), "pivot", "middle", "tip"


def swing(body, t_end, step):
    reduced, pivot, middle, tip = body
    arm = jo.FlexibleBody("arm", reduced)
    model = jo.compile(
        jo.Mechanism(
            arm,
            jo.Spherical("pivot", jo.ground["origin"], arm[pivot]),
            jo.Gravity((0.0, -G, 0.0)),
            jo.PositionSensor("middle", arm[middle]),
            jo.PositionSensor("tip", arm[tip]),
        )
    )
    return jo.simulate(model, t_end, solver=jo.RK4(step=step), output_step=0.01)


@pytest.mark.parametrize("kind", ["average", "rigid"])
def test_both_pendulums_swing_alike(kind):
    bars = beams(STEEL, 8), solids(STEEL, 8, kind)
    f, g = (reduced.frequencies[:4] for reduced, *_ in bars)
    # two bending pairs about the pivot; an end held flat over its whole face or by its mean
    assert np.abs(g / f - 1.0).max() < 2.1e-3
    a, b = (swing(bar, 2.0, 1e-4) for bar in bars)
    for name in ("middle", "tip"):
        assert np.abs(a[name] - b[name]).max() < 1e-5  # m, after a way of 10 m
        assert np.abs(b[name][:, 2]).max() < 1e-10
    # the bar bends by 50 micrometres: sag of the middle under the line from pivot to tip
    sags = [np.linalg.norm(run["middle"] - 0.5 * run["tip"], axis=1).max() for run in (a, b)]
    assert sags[0] > 4e-5
    assert abs(sags[1] / sags[0] - 1.0) < 0.05


@pytest.mark.filterwarnings("ignore:.*softer than most plastics")
def test_soft_pendulums_swing_alike():
    # a thousandth of steel, as in the thesis: the middle sags by 5 cm
    a, b = (swing(make(STEEL / 1000.0, 8), 2.0, 1e-3) for make in (beams, solids))
    sag = np.linalg.norm(a["middle"] - 0.5 * a["tip"], axis=1).max()
    assert sag > 0.04
    for name in ("middle", "tip"):
        assert np.abs(a[name] - b[name]).max() < 0.01 * sag
