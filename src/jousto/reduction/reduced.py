"""The reduced part: everything the simulation of a flexible body needs, and nothing of the mesh."""

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
from jousto.reduction.modes.rigid import length_scale, rigid_modes

SID = (".sid", ".sid_fem")
"""Endings of standard input data."""
RIGID = 1e-9
"""Deformation of the interfaces in a mode over their motion below which they move as one body."""


@dataclass(frozen=True, eq=False)
class ReducedPart(Content):
    """A flexible body described by n modes in its floating frame.

    The frame is that of the part's nodes. Modes are mass-normalised, so that the modal mass matrix
    is the identity and the modal stiffness is ``diag((2 pi f)^2)``. Made by `reduce`.

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
        Rotation of the nodes that turn in each mode, kg^-0.5/m; None where none does.
    frequencies : (n,) array
        Hz.
    invariants : Invariants
        Mass integrals.
    stress : StressModes or None
        Stress of each mode at the places of the part.
    interfaces : tuple of str
        Node sets whose static deformation the modes hold exactly.
    provenance : mapping of str to str
        Method, versions and hash of the input.
    stiffening : Stiffening or None
        Second-order displacements: what makes forces along the body stiffen or soften it.
    rotation_nodes : (nr,) int array or None
        Which nodes turn, ascending: the reference nodes of the interfaces of a solid. None if all
        do (or none does).
    faces : tuple of (nf, k) int array
        Outer faces of a solid by kind, k = 3, 4, 6 or 8 nodes, corners first, then the middles of
        the sides, normals outwards: where strain gauges stick. Empty for beams.
    beams : BeamElements or None
        Axes, lengths and shear of the elements of beams: what points between the nodes need.
    outlines : Outlines or None
        Outer edges of the sections of beams, for drawing.
    source : Part or None
        The part that was reduced, if it is not large (30,000 degrees of freedom): `compile` asks
        it what loads do that the modes leave out. Not saved.

    Raises
    ------
    InputError
        Arrays that do not belong together or are not finite; all problems at once.
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
        """Undeformed positions (3,), m, of the nodes that have a set of their own."""
        return {key: self.nodes[m[0]] for key, m in self.node_sets.items() if len(m) == 1}

    @explained
    def node(self, name: str) -> int:
        """Return the number of the node with this name, from 0.

        Raises
        ------
        InputError
            No such node set, or one with several nodes.
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
        """Return the rotation of a node in each mode (3, n), kg^-0.5/m; None if it does not turn.

        Parameters
        ----------
        node : int
            Node number, from 0.
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
        """Share of the strain energy of each mode that is static, (n,), from 0 to 1.

        The strain energy of a mode is that of the static shape in which loads on the interfaces
        alone move these as the mode does (constraint or attachment modes), and that of a vibration
        with the interfaces held; the two are orthogonal. Modes whose share is above a half are
        corrections: they are there for the interfaces' deformation, not for their frequencies. With
        U the motion of the interfaces in the modes, freed of rigid motion, and the singular vectors
        V of ``U diag(1/omega)``, the shares are the squares of the rows of V, summed: in
        all as many as the interfaces deform independently, 6 (i - 1) for i interface nodes.
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
        # rotations of the rigid motion over the length: the columns are of one size
        scaled = R / np.repeat([1.0, length], 3)
        deformed = U - scaled @ np.linalg.lstsq(scaled, U, rcond=RIGID)[0]
        _, size, V = np.linalg.svd(deformed, full_matrices=False)
        found = size > RIGID * np.abs(U).max(initial=0.0)
        return np.asarray(np.sum(V[found] ** 2, axis=0))

    def keep(self, indices: Sequence[int] | NDArray[Any]) -> ReducedPart:
        """Return the part with only these modes, in the order given.

        Parameters
        ----------
        indices : sequence of int, or boolean array (n,)
            Modes to keep, from 0, each once.

        Raises
        ------
        InputError
            No mode, a mode that does not exist, or one named twice.

        Examples
        --------
        ``rod.keep(rod.in_plane("xy"))`` leaves the modes of plane motion.
        """
        where = f"reduced part '{self.name}'"
        array = np.asarray(indices)
        if array.dtype == bool and array.shape == (self.n,):
            array = np.flatnonzero(array)
        if array.ndim != 1 or not len(array):
            raise InputError(
                Problem(
                    where,
                    "keep needs the numbers of one mode or more",
                    path=("keep",),
                )
            )
        if not np.issubdtype(array.dtype, np.integer):
            raise InputError(
                Problem(
                    where,
                    "keep needs whole numbers of modes, from 0",
                    path=("keep",),
                )
            )
        chosen = array.astype(np.intp)
        if chosen.min() < 0 or chosen.max() >= self.n:
            outside = [int(i) for i in chosen if not 0 <= i < self.n]
            raise InputError(Problem(where, f"there are modes 0..{self.n - 1}, not {outside}"))
        if len(set(chosen.tolist())) != len(chosen):
            raise InputError(Problem(where, "keep names a mode more than once", path=("keep",)))
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
        """Return the numbers of the modes that move in a coordinate plane only.

        A mode is in the plane if its translations out of it and its rotations about axes in it
        stay below the tolerance (root mean square over the nodes, rotations times body size).

        Parameters
        ----------
        plane : str
            ``"xy"``, ``"yz"`` or ``"xz"`` of the part frame.
        tolerance : float
            Largest part of the motion out of the plane.

        Raises
        ------
        InputError
            No such plane.
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
        """Write the part to an HDF5 file; an older file is replaced only when all is written.

        Raises
        ------
        InputError
            The file cannot be written there.
        """
        from jousto.reduction.files.storage import save  # HDF5 is slow to import

        save(self, Path(path))

    @classmethod
    def load(cls, path: str | Path) -> ReducedPart:
        """Read a part written by `save`, or standard input data of another program.

        Standard input data (``.sid``, ``.SID_FEM``) hold nodes, modes and mass integrals, no
        stress; node sets are ``node1``, ... by the numbers of the file. Modes that are not
        orthonormal become those of ``Ke x = omega^2 Me x``; damping ratios of the modes are in
        ``provenance["damping ratios"]``.

        Raises
        ------
        InputError
            No such file, not a reduced part, another version of the format, or damaged.

        Warns
        -----
        JoustoWarning
            What of standard input data is left out.
        """
        if Path(path).suffix.lower() in SID:
            from jousto.reduction.files.sid import load_sid

            return load_sid(Path(path), cls, package_versions())
        from jousto.reduction.files.storage import load

        return load(Path(path), cls)


@functools.cache
def _version(package: str) -> str:
    # its file is read from disk
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


def package_versions() -> dict[str, str]:
    """Return the versions that a result depends on, for its provenance."""
    return {package: _version(package) for package in ("jousto", "numpy", "scipy")}
