"""Reduced part: the data of a flexible body that a simulation needs, without the mesh."""

from __future__ import annotations

import functools
import importlib.metadata
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.reduction.content import Content
from jousto.reduction.files.suffixes import SID
from jousto.reduction.modes.rigid import length_scale, rigid_modes

RIGID = 1e-9
"""Largest deformation of interfaces that move as one rigid body / their motion in a mode."""


@dataclass(frozen=True, eq=False)
class ReducedPart(Content):
    """Flexible body described by n modes in its floating frame.

    The part frame is the frame in which node positions are given. Modes are mass-normalised, so
    that the modal mass matrix is the identity and the modal stiffness is ``diag((2 pi f)^2)``.
    Created by `reduce`.

    Parameters
    ----------
    name : str
        Name of the part.
    nodes : (nn, 3) array
        Undeformed positions, part frame, m.
    elements : (ne, m) int array
        Node numbers of each element, from 0.
    node_sets : mapping of str to tuple of int
        Named nodes, from 0.
    modes : (nn, 3, n) array
        Nodal translation of each mode, part frame, kg^-0.5.
    rotations : (nr, 3, n) array or None
        Rotation of nodes in each mode, kg^-0.5/m; None if no node has rotations.
    frequencies : (n,) array
        Hz.
    invariants : Invariants
        Mass integrals.
    stress : StressModes or None
        Stress of each mode at the stress sites.
    interfaces : tuple of str
        Node sets for which the modes contain the static deformation exactly.
    provenance : mapping of str to str
        Method, versions and hash of the input.
    stiffening : Stiffening or None
        Second-order displacements, by which forces stiffen or soften the body.
    rotation_nodes : (nr,) int array or None
        Nodes with rotations, ascending: the reference nodes of the interfaces of a solid. None if
        all nodes or no nodes have rotations.
    faces : tuple of (nf, k) int array
        Outer faces of a solid by kind, k = 3, 4, 6 or 8 nodes, corners first, then mid-side nodes,
        normals outwards, for strain gauges. Empty for beams.
    beams : BeamElements or None
        Axes, lengths and shear parameters of beam elements, for points between the nodes.
    outlines : Outlines or None
        Outer edges of the sections of beams, for drawing.
    source : Part or None
        The part before reduction, if it has at most 30,000 degrees of freedom, for the response to
        loads outside of the modes. Not saved.

    Raises
    ------
    InputError
        With all arrays that are inconsistent or not finite.
    """

    def __repr__(self) -> str:
        known = ", ".join(f"{f:.5g}" for f in self.frequencies[:4])
        more = ", ..." if self.n > 4 else ""
        return f"<ReducedPart {self.name!r}: {self.n} modes, {known}{more} Hz>"

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.frequencies)

    @property
    def stiffness(self) -> Array:
        """Diagonal of the modal stiffness matrix, ``omega_j^2`` (n,), 1/s2."""
        return np.asarray((2.0 * np.pi * self.frequencies) ** 2)

    @property
    def named_nodes(self) -> dict[str, Array]:
        """Undeformed positions (3,) in m of the nodes that have a node set to themselves."""
        return {key: self.nodes[m[0]] for key, m in self.node_sets.items() if len(m) == 1}

    @explained
    def node(self, name: str) -> int:
        """Return the index (from 0) of the node with a name.

        Raises
        ------
        InputError
            If there is no such node set, or it has several nodes.
        """
        members = self.node_sets.get(name)
        where = f"reduced part '{self.name}'"
        if members is None:
            raise InputError(Problem(where, f"no node '{name}'{suggest(name, self.node_sets)}"))
        if len(members) != 1:
            raise InputError(
                Problem(
                    where,
                    f"node set '{name}' has {len(members)} nodes; name a single node",
                    path=("node",),
                )
            )
        return members[0]

    def rotation(self, node: int) -> Array | None:
        """Return the rotation of a node in each mode (3, n), kg^-0.5/m; None without rotations.

        Parameters
        ----------
        node : int
            Index of the node, from 0.
        """
        if self.rotations is None:
            return None
        if self.rotation_nodes is None:
            return np.asarray(self.rotations[node])
        place = int(np.searchsorted(self.rotation_nodes, node))
        if place == len(self.rotation_nodes) or self.rotation_nodes[place] != node:
            return None
        return np.asarray(self.rotations[place])

    @property
    def static_shares(self) -> Array:
        """Static part of the strain energy of each mode, (n,), between 0 and 1.

        A mode is the sum of a static shape, caused by loads on the interfaces that produce the
        interface motion of the mode (constraint or attachment modes), and of a vibration with fixed
        interfaces; their strain energies add. Modes with a static part above one half describe the
        deformation of the interfaces. Their frequencies bound natural frequencies of the free part
        from above, like the frequencies of the other modes; the static part does not indicate how
        close the bound is.

        With U the motion of the interfaces in the modes without rigid motion, and the singular
        vectors V of ``U diag(1/omega)``, the parts are the sums of squares of the rows of V. Their
        total is the number of independent deformations of the interfaces, 6 (i - 1) for i interface
        nodes.
        """
        length = length_scale(self.nodes)
        moved, rigid = [np.zeros((0, self.n))], [np.zeros((0, 6))]
        for node in (k for name in self.interfaces for k in self.node_sets[name]):
            moved.append(self.modes[node])
            rigid.append(rigid_modes(self.nodes[node : node + 1], 3))
            turn = self.rotation(node)
            if turn is not None:
                moved.append(length * turn)
                rigid.append(np.hstack([np.zeros((3, 3)), length * np.eye(3)]))
        U, R = np.vstack(moved) / np.sqrt(self.stiffness), np.vstack(rigid)
        if not len(U):
            return np.zeros(self.n)
        # rotations of the rigid motion / length, so that the columns are of equal size
        scaled = R / np.repeat([1.0, length], 3)
        deformed = U - scaled @ np.linalg.lstsq(scaled, U, rcond=RIGID)[0]
        _, size, V = np.linalg.svd(deformed, full_matrices=False)
        found = size > RIGID * np.abs(U).max(initial=0.0)
        return np.asarray(np.sum(V[found] ** 2, axis=0))

    def keep(self, indices: Sequence[int] | NDArray[Any]) -> ReducedPart:
        """Return the part with selected modes, in the given order.

        Parameters
        ----------
        indices : sequence of int, or boolean array (n,)
            Indices of the modes, from 0, without duplicates.

        Raises
        ------
        InputError
            If there is no mode, or a mode does not exist or occurs twice.

        Examples
        --------
        ``rod.keep(rod.in_plane("xy"))`` returns the modes of plane motion.
        """
        where = f"reduced part '{self.name}'"
        array = np.asarray(indices)
        if array.dtype == bool and array.shape == (self.n,):
            array = np.flatnonzero(array)
        if array.ndim != 1 or not len(array):
            raise InputError(
                Problem(
                    where,
                    "keep needs the index of at least one mode",
                    path=("keep",),
                )
            )
        if not np.issubdtype(array.dtype, np.integer):
            raise InputError(
                Problem(
                    where,
                    "keep needs whole numbers, the indices of modes from 0",
                    path=("keep",),
                )
            )
        chosen = array.astype(np.intp)
        if chosen.min() < 0 or chosen.max() >= self.n:
            outside = [int(i) for i in chosen if not 0 <= i < self.n]
            raise InputError(Problem(where, f"there are modes 0..{self.n - 1}, not {outside}"))
        if len(set(chosen.tolist())) != len(chosen):
            raise InputError(Problem(where, "keep contains a mode more than once", path=("keep",)))
        return replace(
            self,
            modes=self.modes[:, :, chosen],
            rotations=None if self.rotations is None else self.rotations[:, :, chosen],
            frequencies=self.frequencies[chosen],
            invariants=self.invariants.keep(chosen),
            stress=None if self.stress is None else self.stress.keep(chosen),
            stiffening=None if self.stiffening is None else self.stiffening.keep(chosen),
        )

    def in_plane(self, plane: str, *, tolerance: float = 1e-3) -> tuple[int, ...]:
        """Return the indices of the modes whose motion lies in a coordinate plane.

        A mode is in the plane if its translations out of it and its rotations about axes in it
        stay below the tolerance (root mean square over the nodes, rotations times body size).

        Parameters
        ----------
        plane : str
            ``"xy"``, ``"yz"`` or ``"xz"`` of the part frame.
        tolerance : float
            Largest ratio of the motion out of the plane to the whole motion.

        Raises
        ------
        InputError
            If there is no such plane.
        """
        normals = {"xy": 2, "yx": 2, "yz": 0, "zy": 0, "xz": 1, "zx": 1}
        if plane not in normals:
            where = f"reduced part '{self.name}'"
            raise InputError(
                Problem(
                    where,
                    f"plane is {plane!r}, must be 'xy', 'yz' or 'xz'",
                    path=("plane",),
                )
            )
        normal = normals[plane]
        tangents = [a for a in range(3) if a != normal]
        total = np.einsum("kaj,kaj->j", self.modes, self.modes)
        outside = np.einsum("kj,kj->j", self.modes[:, normal], self.modes[:, normal])
        if self.rotations is not None:
            turns = self.rotations * length_scale(self.nodes)
            total = total + np.einsum("kaj,kaj->j", turns, turns)
            outside = outside + np.einsum("kaj,kaj->j", turns[:, tangents], turns[:, tangents])
        return tuple(int(j) for j in np.flatnonzero(outside <= tolerance**2 * total))

    def save(self, path: str | Path) -> None:
        """Write the part to an HDF5 file.

        An existing file is replaced when the new one is complete.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        from jousto.reduction.files.storage import save  # HDF5 is slow to import

        save(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> ReducedPart:
        """Read a part written by `save`, or standard input data of another program.

        Standard input data (``.sid``, ``.SID_FEM``) contain nodes, modes and mass integrals, but no
        stress; node sets are ``node1``, ... by the numbers of the file. Modes that are not
        orthonormal become those of ``Ke x = omega^2 Me x``; damping ratios of the modes are in
        ``provenance["damping ratios"]``.

        Raises
        ------
        InputError
            If the file does not exist, is not a reduced part, has another version of the format, or
            is damaged.

        Warns
        -----
        JoustoWarning
            With the content of standard input data that is left out.
        """
        if Path(path).suffix.lower() in SID:
            from jousto.reduction.files.sid import load_sid

            return load_sid(Path(path), cls, package_versions())
        from jousto.reduction.files.storage import load

        return load(Path(path), cls)


@functools.cache
def _version(package: str) -> str:
    # read from a file of the package
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def package_versions() -> dict[str, str]:
    """Return the versions of packages on which a result depends, for its provenance."""
    return {package: _version(package) for package in ("jousto", "numpy", "scipy")}
