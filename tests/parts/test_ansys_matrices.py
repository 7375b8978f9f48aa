"""Ansys's .full files: a file that Ansys wrote and ansys-mapdl-reader ships."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose

import jousto as jo
from jousto.base.errors import InputError
from jousto.parts.part import Part
from parts.matrix_files import full

with warnings.catch_warnings(), np.printoptions():
    warnings.simplefilter("ignore")
    examples = pytest.importorskip("ansys.mapdl.reader.examples")


def test_cantilever_of_ansys() -> None:
    # titanium in pounds and inches, 1 x 1 x 5 in, clamped at z = 0
    matrices = jo.parts.read_matrices(examples.fullfile, units="in-lbf-s")
    assert len(matrices.held) == 63 and len(matrices.nodes) == 321
    u = matrices.used
    assert len(u) == 3 * 321 - 63
    assert_allclose(np.ptp(matrices.nodes, axis=0), [0.0254, 0.0254, 0.127], rtol=1e-12)
    K, M = full(matrices.K)[np.ix_(u, u)], full(matrices.M)[np.ix_(u, u)]
    f = np.sqrt(scipy.linalg.eigh(K, M, eigvals_only=True, subset_by_index=[0, 3])) / 2.0 / np.pi
    # first torsion c_s / (4 L) sqrt(J / Ip) with J = 0.1406 a^4; the examples of that package
    # have E = 16.9e6 psi, rho = 4.1408e-4 lbf s^2 / in^4, nu = 0.31
    shear = np.sqrt(16.9e6 / (2.0 * 1.31) / 4.1408e-4)
    assert f[2] == pytest.approx(shear / 20.0 * np.sqrt(0.1406 * 6.0), rel=0.02)
    # first bending of a cantilever, Euler-Bernoulli, a stout one is 2 to 3 % softer
    bending = 1.8751**2 / (2.0 * np.pi * 25.0) * np.sqrt(16.9e6 / 4.1408e-4 / 12.0)
    assert 0.96 * bending < f[0] < bending and f[1] == pytest.approx(f[0], rel=1e-6)
    with pytest.raises(InputError, match=r"written with supports \(63 directions held: node 1 ux"):
        Part.from_file(examples.fullfile, units="in-lbf-s")


def test_damaged_full_file(tmp_path: Path) -> None:
    data = Path(examples.fullfile).read_bytes()
    path = tmp_path / "job.full"
    nodes = np.zeros((321, 3))
    path.write_text("not a full file at all\n" * 30)
    with pytest.raises(InputError, match="job.full: is not an Ansys .full file"):
        jo.parts.read_matrices(path, nodes=nodes)
    path.write_bytes(Path(examples.rstfile).read_bytes())
    with pytest.raises(InputError, match="is a binary file of Ansys of another kind"):
        jo.parts.read_matrices(path, nodes=nodes)
    for part, message in ((2, "it has .* of 801596 bytes"), (5000, "it ends after 170 bytes")):
        path.write_bytes(data[: len(data) // part])
        with pytest.raises(InputError, match=f"job.full: is truncated: {message}"):
            jo.parts.read_matrices(path, nodes=nodes)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="job.full: is not an Ansys .full file"):
        jo.parts.read_matrices(path, nodes=nodes)
