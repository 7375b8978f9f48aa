"""Standard input data (SID) of flexible bodies, a text format of multibody programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array, skew
from jousto.output.files.exported_nodes import damping_ratios, exposed_nodes, node_modes, write_text
from jousto.reduction.files.sid import SPIN
from jousto.reduction.reduced import ReducedPart


@dataclass(frozen=True, eq=False)
class Taylor:
    """Taylor expansion ``M(q) = M0 + sum_k M1[:, :, k] q_k``; M1 is None if it is zero."""

    M0: Array
    M1: Array | None = None
    symmetric: bool = False

    def lines(self, name: str, indent: str) -> list[str]:
        """Return the lines of the block; structure 0 is a zero matrix, 2 symmetric, 3 full."""
        rows, columns = self.M0.shape
        nq = 0 if self.M1 is None else self.M1.shape[2]
        structure = 0 if not self.M0.any() else 2 if self.symmetric else 3
        head = {
            "order": int(self.M1 is not None),
            "nrow": rows,
            "ncol": columns,
            "nq": nq,
            "nqn": 0,
            "structure": structure,
        }
        lines = [f"{name} "]
        lines += [f"    {key:<12} = {value:6d}" for key, value in head.items()]
        if structure:
            lines += [
                f"    m0({i + 1:4d},{j + 1:4d})      = {_number(self.M0[i, j])}"
                for i in range(rows)
                for j in range(i + 1 if structure == 2 else columns)
            ]
        if self.M1 is not None:
            lines += [
                f"    m1({i + 1:4d},{k + 1:4d},{j + 1:4d}) = {_number(self.M1[i, j, k])}"
                for i in range(rows)
                for j in range(columns)
                for k in range(nq)
            ]
        return [indent + line for line in [*lines, f"end {name}"]]


@explained_as("write")
def write_sid(
    reduced: ReducedPart,
    path: str | Path,
    *,
    nodes: Sequence[str | int] | None = None,
    damping: float | Sequence[float] = 0.0,
) -> Path:
    """Write a reduced part as standard input data (.sid, .SID_FEM).

    The matrices are expanded in the modal coordinates to first order (Wallrapp: Standardization
    of flexible body modeling in multibody system codes, Mech. Struct. Mach. 22, 1994; Schwertassek
    and Wallrapp: Dynamik flexibler Mehrkoerpersysteme, 1999, table 6.9). With the invariants of
    this package and ``q = p``:

    ``mdCM = I2 + I3 q``, ``J = I7 + (I8_k + I8_k^T) q_k``, ``Ct = I3^T``,
    ``Cr = I4^T + I5_k^T q_k``, ``Me = E``, ``Gr_j = 2 (I8_j + I9_kj q_k)``, ``Ge_j = 2 I5_j^T``,
    ``Oe w w = -w^T (I8_j + I9_jk q_k) w``, ``Ke = diag(omega^2)``. Stiffening, where the part has
    it, goes into Oe and into the shapes of the nodes.

    Parameters
    ----------
    reduced : ReducedPart
    path : str or Path
    nodes : sequence of str or int, optional
        Node sets or node numbers from 0; by default all for parts with up to 500 nodes, else those
        of interfaces and of named nodes. They are numbered from 1, with their names behind "!".
    damping : float or sequence of float
        Damping ratio, of all modes or of each.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If a node does not exist or the file cannot be written.
    """
    target = Path(path)
    index, names = exposed_nodes(reduced, nodes, target.name)
    ratios = damping_ratios(reduced, damping, target.name)
    lines = [
        f"{len(index):10d}{reduced.n:10d}   number of nodes and modes, part {reduced.name}, SI",
        "part",
        "    new modal",
        "        refmod",
        f"            mass           = {_number(reduced.invariants.mass)}",
        f"            nelastq        = {reduced.n:6d}",
    ]
    lines += [
        f"            ielastq ({j + 1:4d}) = Eigen Mode {j + 1:4d} : {f:15.6f} Hz"
        for j, f in enumerate(reduced.frequencies)
    ]
    lines += ["        end refmod", "        frame"]
    translations, rotations = node_modes(reduced, index)
    for k, (i, name) in enumerate(zip(index, names, strict=True)):
        lines += [f"            new node   = {k + 1}", "                rframe = body ref"]
        for key, taylor in _node(reduced, int(i), translations[k], rotations[k]).items():
            lines += taylor.lines(key, " " * 16)
        lines.append(f"            end node  ! {name}")
    lines.append("        end frame")
    for key, taylor in sid_matrices(reduced, ratios).items():
        lines += taylor.lines(key, " " * 8)
    write_text(target, "\n".join([*lines, "    end modal", "end part", ""]))
    return target


def sid_matrices(reduced: ReducedPart, ratios: Array) -> dict[str, Taylor]:
    """Return the matrices of the body by their names in the file."""
    inv, n = reduced.invariants, reduced.n
    I5, I8, I9 = inv.I5, inv.I8, inv.I9
    # centrifugal force on mode j: -Oe [wx^2 wy^2 wz^2 wx wy wy wz wz wx]
    C, Cq = -I8, -I9
    if reduced.stiffening is not None:
        N = reduced.stiffening.second_moment
        trace = np.trace(N, axis1=2, axis2=3)[..., None, None]
        Cq = Cq - (trace * np.eye(3) - np.swapaxes(N, 2, 3))
    Oe0, Oe1 = np.zeros((n, 6)), np.zeros((n, 6, n))
    for column, (a, b) in enumerate(SPIN):
        mixed = a != b
        Oe0[:, column] = C[:, a, b] + (C[:, b, a] if mixed else 0.0)
        Oe1[:, column] = Cq[:, :, a, b] + (Cq[:, :, b, a] if mixed else 0.0)
    omega = np.sqrt(reduced.stiffness)
    return {
        "mdCM": Taylor(inv.I2[:, None], inv.I3[:, None, :]),
        "J": Taylor(inv.I7, (I8 + I8.transpose(0, 2, 1)).transpose(1, 2, 0), symmetric=True),
        "Ct": Taylor(inv.I3.T),
        # I5[j, a, i]: rows i, columns a, coordinate j
        "Cr": Taylor(inv.I4.T, I5.transpose(2, 1, 0)),
        "Me": Taylor(np.eye(reduced.n), symmetric=True),
        # blocks of three columns for each mode j; I9[k, j, a, b] with the coordinate k last
        "Gr": Taylor(
            2.0 * I8.transpose(1, 0, 2).reshape(3, 3 * n),
            2.0 * I9.transpose(2, 1, 3, 0).reshape(3, 3 * n, n),
        ),
        "Ge": Taylor(2.0 * I5.transpose(2, 0, 1).reshape(n, 3 * n)),
        "Oe": Taylor(Oe0, Oe1),
        "ksigma": Taylor(np.zeros((n, 1))),
        "Ke": Taylor(np.diag(reduced.stiffness), symmetric=True),
        "De": Taylor(np.diag(2.0 * ratios * omega), symmetric=True),
    }


def _node(reduced: ReducedPart, i: int, phi: Array, psi: Array) -> dict[str, Taylor]:
    """Return the data of a node: position, translation and rotation shapes, orientation."""
    more = reduced.stiffening
    return {
        "origin": Taylor(reduced.nodes[i][:, None], phi[:, None, :]),
        "phi": Taylor(phi, None if more is None else more.translations[i]),
        "psi": Taylor(psi, None if more is None else more.rotations[i]),
        "AP": Taylor(np.eye(3), skew(psi.T).transpose(1, 2, 0)),
        "sigma": Taylor(np.zeros((6, 1))),
    }


def _number(value: float) -> str:
    """Return a number with the exponent letter D of Fortran."""
    return f"{value:23.15E}".replace("E", "D")
