"""Frames of beams: checks of the input, assembly of stiffness, mass points and stress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, node_dofs, scatter
from jousto.base.complexstep import is_stepping, norm
from jousto.base.errors import Problems, warn
from jousto.base.fields import AnyField, Flag, Label, Nested, field
from jousto.base.numbers import Values
from jousto.materials.library import by_name
from jousto.materials.material import Material
from jousto.mesh.sets import connectivity, node_index, read_elements, read_sets, unattached
from jousto.parts.form import Dictionary, PartForm
from jousto.parts.frames.element import (
    BeamElements,
    EulerBernoulli,
    Theory,
    Timoshenko,
    default_orientation,
    end_displacements,
    local_axes,
    shape_functions,
    stiffness,
)
from jousto.parts.frames.second_order import SecondOrder
from jousto.parts.frames.stress import StressOperator, beam_stress
from jousto.parts.mass import MassPoints, PointMass, joined, rigid_points
from jousto.sections.section import Section, is_section

# sizes of sections and parts, m, above which they were probably given in mm
WIDEST, LARGEST = 5.0, 200.0


class TheoryField(Nested[Theory | None, Theory | None]):
    """Field of a theory of beams; `check_frame` checks it."""

    section = "theories"
    room = "jousto.parts.frames"
    noun = "EulerBernoulli or Timoshenko"


class BeamOptions(PartForm):
    """Options of the beams of a part: mass, theory and attached masses."""

    lumped: Flag = field(
        "Whether half of the mass of each element is at each of its ends, instead of the "
        "consistent mass",
        default=False,
        kw_only=True,
    )
    rotary_inertia: Flag = field(
        "Whether sections have rotary inertia (torsion and bending). Without it, rotations of "
        "lumped beams have mass only from offsets and point masses",
        default=True,
        kw_only=True,
    )
    theory: TheoryField = field("Beam theory; None for Timoshenko()", default=None, kw_only=True)
    point_masses: AnyField = field(
        "Rigid masses on nodes",
        form="point masses",
        noun="PointMass or sequence of PointMass",
        default=(),
        kw_only=True,
    )
    name: Label = field("Name of the part", file=False, default="frame", kw_only=True)


class FrameArrays(BeamOptions):
    """Beams in space, given by arrays of their nodes and elements."""

    nodes: Values = field("Positions, part frame", unit="m", shape=(None, 3))
    elements: AnyField = field(
        "Indices (from 0) of the nodes at the ends a and b of each element",
        form="pairs",
        noun="(ne, 2) array_like of int",
    )
    sections: AnyField = field(
        "One for all elements, or one per element",
        form="sections",
        noun="Section or sequence of Section",
        kw_only=True,
    )
    materials: AnyField = field(
        "One for all elements, or one per element",
        form="materials",
        noun="Material or sequence of Material",
        kw_only=True,
    )
    orientations: AnyField = field(
        "Vector near the local z axis of the element, part frame. If not given: (0, 0, 1), and "
        "(1, 0, 0) for members parallel to z",
        form="shapes",
        shapes=((3,), (None, 3)),
        noun="(3,) or (ne, 3) array_like",
        default=None,
        kw_only=True,
    )
    offsets: AnyField = field(
        "Rigid arms from the nodes to the ends of the beam, part frame",
        unit="m",
        form="shapes",
        shapes=((None, 2, 3),),
        noun="(ne, 2, 3) array_like",
        default=None,
        kw_only=True,
    )
    node_sets: Dictionary = field(
        "Indices of nodes, from 0",
        form="node sets",
        noun="mapping of str to node indices",
        default=None,
        kw_only=True,
    )


@dataclass(frozen=True, eq=False)
class Frame:
    """Checked frame: all data of a Part of beams."""

    name: str
    nodes: Array
    elements: Ints
    node_sets: Mapping[str, tuple[int, ...]]
    beams: BeamElements
    sections: tuple[Section, ...]
    density: Array
    options: BeamOptions
    point_masses: tuple[PointMass, ...]


def check_frame(given: FrameArrays) -> Frame:
    """Return the frame described by arrays.

    Raises
    ------
    InputError
        With all problems of the arguments.
    """
    where, problems = f"part '{given.name}'", Problems()
    orientations = given.orientations
    theory: object = given.theory or Timoshenko()
    if not isinstance(theory, (EulerBernoulli, Timoshenko)):
        problems.add(
            where,
            f"theory is {theory!r}, must be EulerBernoulli() or Timoshenko()",
            "theory",
        )
    xyz = problems.array(where, "nodes", given.nodes, (None, 3))
    nn = 0 if xyz is None else len(xyz)
    ab = None if xyz is None else read_elements(problems, where, given.elements, nn, 2)
    if xyz is None or ab is None:
        problems.raise_if_any()
        raise AssertionError("unreachable")
    ne = len(ab)

    # section and material of each element
    section: list[Section] | None = _per_element(
        problems, where, "section", given.sections, ne, Section
    )
    material: list[Material] | None = _per_element(
        problems, where, "material", given.materials, ne, Material
    )
    shape: tuple[int, ...] = (3,) if np.ndim(orientations) == 1 else (ne, 3)
    up = None
    if orientations is not None:
        up = problems.array(where, "orientations", orientations, shape)
        up = None if up is None else np.broadcast_to(up, (ne, 3))
    arms: Array | None = np.zeros((ne, 2, 3))
    if given.offsets is not None:
        arms = problems.array(where, "offsets", given.offsets, (ne, 2, 3))

    # geometry
    origin, axes, length = xyz[ab[:, 0]], np.zeros((ne, 3, 3)), np.ones(ne)
    if arms is not None and (orientations is None or up is not None):
        origin, axes, length = _geometry(problems, where, xyz, ab, arms, up)
    sets = read_sets(problems, where, given.node_sets or {}, nn)
    masses = _point_masses(problems, where, given.point_masses, sets, nn)
    unattached(problems, where, ab, nn)
    if not problems.found:
        connectivity(problems, where, xyz, ab)
    phi = np.zeros((ne, 2))
    if section and material and isinstance(theory, Timoshenko):
        phi = _shear_parameters(problems, where, section, material, length, theory)
    problems.raise_if_any()
    assert section is not None and material is not None and arms is not None

    A, Iy, Iz, J = _section_constants(section)
    E = np.array([m.E for m in material])
    G = np.array([m.G for m in material])
    rho = np.array([m.rho for m in material])
    if not rho.any() and not any(p.mass > 0.0 for p in masses):
        problems.add(where, "has no mass: every density is zero and there are no point masses")
        problems.raise_if_any()
    size = float(np.ptp(xyz.real, axis=0).max())
    if is_stepping():
        pass  # the message was given for the real values
    elif float(np.sqrt(A.max())) > size:
        warn(where, f"a section of {np.sqrt(A.max()):g} m is larger than the part, {size:g} m")
    elif rho.max() >= 1.0:  # kg/m^3: with this density the units are not another consistent system
        if size > LARGEST:
            warn(where, f"is {size:g} m large; if its lengths are in mm, convert them to m")
        elif float(np.sqrt(A.max())) > WIDEST:
            warn(
                where,
                f"a section of {np.sqrt(A.max()):g} m; if its sizes are in mm, convert them to m",
            )
    beams = BeamElements(origin, axes, length, arms, E * A, G * J, E * Iy, E * Iz, phi)
    density = np.stack([rho * A, rho * Iy, rho * Iz], axis=1)
    return Frame(given.name, xyz, ab, sets, beams, tuple(section), density, given, masses)


def assemble(
    frame: Frame,
) -> tuple[Sparse, Sparse, MassPoints, StressOperator | None, SecondOrder]:
    """Return K, M, the mass points, the stress operator and the second-order forms of a frame.

    The mass matrix is computed from the mass points.
    """
    beams, nn = frame.beams, len(frame.nodes)
    dofs = node_dofs(frame.elements, 6)
    B = end_displacements(beams)
    k = np.swapaxes(B, 1, 2) @ stiffness(beams) @ B
    K = scatter(0.5 * (k + np.swapaxes(k, 1, 2)), dofs, dofs, (6 * nn, 6 * nn))
    along, rigid = mass_points_along(frame), mass_points_on_nodes(frame)
    points = rigid
    rhoA, line_moment = np.zeros(len(beams)), np.zeros((len(beams), 3, 3))
    if along is not None:
        points = joined([along, rigid]) if len(rigid) else along
        rhoA, line_moment = frame.density[:, 0], _line_moment(frame)
    stress = beam_stress(beams, frame.sections, frame.elements, 6 * nn)
    gyration = (beams.EIy + beams.EIz) / beams.EA
    second = SecondOrder(beams, frame.elements, rhoA, line_moment, gyration, rigid, 6 * nn)
    return K, points.matrix(), points, stress, second


def mass_points_on_nodes(frame: Frame) -> MassPoints:
    """Return the mass fixed to nodes: point masses and, if lumped, half elements.

    A half element has the rotary inertia of the sections, ``rho (Iy + Iz) L/2`` about the axis and
    ``rho I L/2`` about the transverse axes; the term ``m L^2/24`` of a half element rotating about
    its end is left out, because the translational masses already exceed the inertia of the member
    (by m L^2/6). All masses at a node are merged into one point.
    """
    beams, nodes, options = frame.beams, frame.nodes, frame.options
    node = [node_index(p.node, frame.node_sets) for p in frame.point_masses]
    mass = np.array([p.mass for p in frame.point_masses])
    offset = np.array([p.offset for p in frame.point_masses]).reshape(-1, 3)
    J = np.array([p.inertia for p in frame.point_masses]).reshape(-1, 3, 3)
    moment = 0.5 * np.trace(J, axis1=1, axis2=2)[:, None, None] * np.eye(3) - J
    where = np.array(node, dtype=np.int64)
    if options.lumped:
        half, g = 0.5 * beams.length, _line_moment(frame)
        where = np.concatenate([where, frame.elements.T.ravel()])
        mass = np.concatenate([mass, np.tile(frame.density[:, 0] * half, 2)])
        offset = np.concatenate([offset, beams.offsets[:, 0], beams.offsets[:, 1]])
        moment = np.concatenate([moment, np.tile(g * half[:, None, None], (2, 1, 1))])
    return rigid_points(where, mass, offset, moment, nodes)


def mass_points_along(frame: Frame) -> MassPoints | None:
    """Return the distributed mass of the elements, or None if it is lumped.

    Each element has four Gauss points (exact for the cubic shape functions) with the rotary inertia
    of their slices.
    """
    if frame.options.lumped:
        return None
    beams, nodes, g = frame.beams, frame.nodes, _line_moment(frame)
    rhoA = frame.density[:, 0]
    heavy = np.flatnonzero(rhoA > 0.0)
    ne, ndof = len(beams), 6 * len(nodes)
    abscissae, weights = np.polynomial.legendre.leggauss(4)
    xi, weights = 0.5 * (1.0 + abscissae), 0.5 * weights
    B, axes, L = end_displacements(beams), beams.axes, beams.length
    N = np.stack([shape_functions(beams, x) @ B for x in xi], axis=1)
    N = (axes[:, None, None] @ N.reshape(ne, 4, 2, 3, 12))[heavy].reshape(-1, 2, 3, 12)
    rows = node_dofs(np.arange(len(N))[:, None], 3)
    columns = np.repeat(node_dofs(frame.elements[heavy], 6), 4, axis=0)
    position = beams.origin[:, None] + xi[:, None] * (L[:, None] * axes[:, :, 0])[:, None]
    return MassPoints(
        mass=((rhoA * L)[heavy, None] * weights).ravel(),
        position=position[heavy].reshape(-1, 3),
        second_moment=((L[:, None, None] * g)[heavy, None] * weights[:, None, None]).reshape(
            -1, 3, 3
        ),
        N=scatter(N[:, 0], rows, columns, (3 * len(N), ndof)),
        N_rot=scatter(N[:, 1], rows, columns, (3 * len(N), ndof)),
    )


def _line_moment(frame: Frame) -> Array:
    """Return the second moment per length of the sections (ne, 3, 3), part axes, kg m."""
    _, rhoIy, rhoIz = frame.density.T
    # second moments in local axes: x none, y from Iz, z from Iy
    g = np.zeros((len(frame.beams), 3, 3), np.result_type(rhoIy, rhoIz))
    if frame.options.rotary_inertia:
        g[:, 1, 1], g[:, 2, 2] = rhoIz, rhoIy
    axes = frame.beams.axes
    return np.asarray(axes @ g @ np.swapaxes(axes, 1, 2))


def _per_element(
    problems: Problems, where: str, name: str, value: Any, ne: int, kind: Any
) -> list[Any] | None:
    """Return one object per element; a single object is used for all elements."""

    def fits(item: object) -> bool:
        return is_section(item) if kind is Section else isinstance(item, kind)

    if fits(value):
        return [value] * ne
    if not isinstance(value, Sequence) or isinstance(value, str):
        how = by_name(value) if kind is Material else ""
        wanted = f"a {kind.__name__} or one per element{how}"
        problems.add(where, f"{name} is {value!r}, must be {wanted}", name)
        return None
    wrong = [i for i, item in enumerate(value) if not fits(item)]
    if wrong:
        i = wrong[0]
        problems.add(where, f"{name}s[{i}] is {value[i]!r}, must be a {kind.__name__}")
    elif len(value) != ne:
        problems.add(where, f"{len(value)} {name}s for {ne} elements, must be one or {ne}")
    else:
        return list(value)
    return None


def _geometry(
    problems: Problems, where: str, xyz: Array, ab: Ints, arms: Array, up: Array | None
) -> tuple[Array, Array, Array]:
    """Return origin, axes and length of the elements; report zero lengths and bad orientations."""
    a, b = xyz[ab[:, 0]] + arms[:, 0], xyz[ab[:, 1]] + arms[:, 1]
    length = norm(b - a, axis=1)
    short = length <= 1e-12 * max(float(np.abs(xyz).max()), float(length.real.max()))
    for e in np.flatnonzero(short)[:6]:
        problems.add(
            where,
            f"element {e + 1} (nodes {ab[e, 0] + 1} and {ab[e, 1] + 1}) has zero length",
            "element",
        )
    if up is None:
        up = default_orientation(b - a)
    axes = local_axes(b - a, up)
    parallel = np.isnan(axes).any(axis=(1, 2)) & ~short
    for e in np.flatnonzero(parallel)[:6]:
        problems.add(
            where,
            f"orientation {up[e].tolist()} of element {e + 1} is zero or parallel to the element;"
            " give a vector across it, near the local z axis",
            "orientation",
        )
    return a, axes, length


def _section_constants(sections: Sequence[Section]) -> Array:
    """Return A, Iy, Iz, J of each element, (4, ne); each section is evaluated once."""
    known: dict[int, tuple[float, float, float, float]] = {}
    for s in sections:
        if id(s) not in known:
            known[id(s)] = (s.A, s.Iy, s.Iz, s.J)
    return np.array([known[id(s)] for s in sections]).T


def _shear_parameters(
    problems: Problems,
    where: str,
    sections: Sequence[Section],
    materials: Sequence[Material],
    length: Array,
    theory: Timoshenko,
) -> Array:
    """Return the shear parameters (ne, 2) of Timoshenko beams."""
    known: dict[int, tuple[float, float]] = {}
    for e, s in enumerate(sections):
        if id(s) not in known:
            ky = s.ky if theory.ky is None else theory.ky
            kz = s.kz if theory.kz is None else theory.kz
            if ky is None or kz is None:
                problems.add(
                    where,
                    f"section of element {e + 1} has no shear coefficients ky and kz; give them"
                    " or use theory=EulerBernoulli()",
                    "section",
                )
                ky = kz = 1.0
            known[id(s)] = (s.Iz / (ky * s.A), s.Iy / (kz * s.A))
    ratio = np.array([known[id(s)] for s in sections])
    E_over_G = np.array([m.E / m.G for m in materials])
    with np.errstate(divide="ignore"):
        phi: Array = 12.0 * ratio * (E_over_G / length**2)[:, None]
    return phi


def _point_masses(
    problems: Problems,
    where: str,
    point_masses: Any,
    sets: Mapping[str, tuple[int, ...]],
    nn: int,
) -> tuple[PointMass, ...]:
    """Return the point masses; report those that are not on exactly one node of the part."""
    masses = problems.several(where, "point_masses", point_masses, PointMass)
    for i, p in enumerate(masses):
        try:
            node = node_index(p.node, sets)
        except KeyError as error:
            problems.add(where, f"point_masses[{i}]: {error.args[0]}", "point_masses", i)
            continue
        if not 0 <= node < nn:
            problems.add(
                where, f"point_masses[{i}]: node {node} is not in 0..{nn - 1}", "point_masses", i
            )
    return masses
