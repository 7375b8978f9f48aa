"""Modes followed over a parameter, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

G = 9.81


def two_rods(length: float) -> jo.Model:
    """Rods of 1 m and of `length` that hang side by side without touching."""
    parts = []
    for name, size, z in (("fixed", 1.0, 0.0), ("varied", length, 1.0)):
        body = jo.RigidBody(
            name,
            2.0,
            (2.0 * size**2 / 12, 1e-3, 2.0 * size**2 / 12),
            position=(0, -size / 2, z),
            markers={"top": (0, size / 2, 0)},
        )
        hinge = jo.Revolute(f"{name} pin", jo.ground.at((0, 0, z)), body["top"], axis=(0, 0, 1))
        parts += [body, hinge]
    return jo.compile(jo.Mechanism(*parts, jo.Gravity((0, -G, 0))))


def closed(length):
    return np.sqrt(1.5 * G / np.asarray(length)) / (2 * np.pi)


def test_crossing_modes_keep_their_line():
    lengths = np.array([1.5, 1.2, 0.9, 0.6])
    found = jo.simulation.campbell(two_rods, lengths, parameter="length (m)")
    # the longer rod is the slower one at first, and passes the other
    np.testing.assert_allclose(found.frequencies[:, 0], closed(lengths), rtol=1e-9)
    np.testing.assert_allclose(found.frequencies[:, 1], closed(1.0), rtol=1e-9)
    np.testing.assert_allclose(found.damping, 0.0, atol=1e-9)


def test_values_must_be_there():
    with pytest.raises(jo.InputError, match="not empty"):
        jo.simulation.campbell(two_rods, [])


def test_pictures_show_every_mode_and_order(tmp_path):
    found = jo.simulation.campbell(two_rods, [1.5, 0.6], parameter="length (m)")
    figure = jo.plot(found, orders=(1.0,), path=tmp_path / "campbell.png")
    (ax,) = figure.axes
    assert ax.get_xlabel() == "length (m)"
    np.testing.assert_array_equal(ax.get_lines()[0].get_ydata(), found.frequencies[:, 0])
    np.testing.assert_allclose(ax.get_lines()[2].get_ydata(), np.array([1.5, 0.6]) / (2 * np.pi))
    locus = jo.plot(found, kind="root locus", path=tmp_path / "locus.svg")
    np.testing.assert_array_equal(
        locus.axes[0].get_lines()[0].get_ydata(), found.eigenvalues[:, 0].imag
    )
    assert (tmp_path / "campbell.png").exists()
    assert (tmp_path / "locus.svg").exists()
