"""Beam sections and materials of Abaqus and CalculiX input files."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.mesh.readers.inp_blocks import Block, real
from jousto.parts.matrices.units import Units
from jousto.sections.profiles import Box, IBeam
from jousto.sections.section import Circle, GeneralSection, Rectangle, Section, Tube

DEFAULT_N1 = (0.0, 0.0, -1.0)
"""Default of the first axis of a section."""

ROUND = (Circle, Tube)


@dataclass(frozen=True)
class DeckSection:
    """Section of a deck with its axes and its material, SI units.

    Attributes
    ----------
    section : Section
        Section, whose y and z axes are the axes 1 and 2 of the deck, rotated by `turn`.
    material : Material
    n1 : (3,) ndarray
        Axis 1 in the assembly, not yet normal to the beam.
    turn : float
        Angle in rad from the axes of the deck to the principal ones.
    shift : float
        Height of the centroid above the node along axis 2, m.
    """

    section: Section
    material: Material
    n1: Array
    turn: float = 0.0
    shift: float = 0.0


@dataclass
class _Numbers:
    """Material constants of a deck, in the units of the deck."""

    E: float = 0.0
    nu: float = 0.0
    rho: float = 0.0
    wrong: list[str] = field(default_factory=list)


def deck_materials(blocks: Iterable[Block], units: Units) -> dict[str, Material]:
    """Return the materials of a deck by name in upper case.

    Raises
    ------
    InputError
        If a material is not isotropic, or has no elasticity.
    """
    found: dict[str, tuple[Block, _Numbers]] = {}
    now: _Numbers | None = None
    for block in blocks:
        if block.keyword == "MATERIAL":
            now = _Numbers()
            found[block.text("NAME").upper()] = block, now
        elif now is None:
            continue
        elif block.keyword == "ELASTIC":
            if block.text("TYPE").upper() not in ("", "ISO", "ISOTROPIC"):
                raise block.wrong("beams need an isotropic material: E and Poisson's ratio")
            now.E, now.nu = (*numbers(block, 0), 0.0)[:2]
        elif block.keyword == "DENSITY":
            now.rho = numbers(block, 0)[0]
    out = {}
    for name, (block, says) in found.items():
        if not says.E > 0.0:
            raise block.wrong(f"material '{block.text('NAME')}' has no *ELASTIC below it")
        out[name] = material_of(block.text("NAME"), says.E, says.nu, says.rho, units)
    return out


def material_of(name: str, E: float, nu: float, rho: float, units: Units) -> Material:
    """Return a material from values in the units of the deck."""
    return Material(
        E=E * units.force / units.length**2,
        nu=nu,
        rho=rho * units.mass / units.length**3,
        name=name,
    )


def numbers(block: Block, row: int) -> list[float]:
    """Return the numbers of a data line; empty if there is no such line."""
    rows = block.rows
    if row >= len(rows):
        return []
    try:
        return [real(word) for word in rows[row] if word or any(rows[row])]
    except ValueError:
        raise block.wrong(f"'{', '.join(rows[row])[:40]}' are not numbers") from None


def deck_section(
    block: Block, turn: Array, materials: dict[str, Material], units: Units
) -> DeckSection:
    """Return the section of ``*BEAM SECTION`` or ``*BEAM GENERAL SECTION``.

    Parameters
    ----------
    block : Block
    turn : (3, 3) ndarray
        Rotation of the instance.
    materials : dict
        Materials of the deck by name in upper case.
    units : Units

    Raises
    ------
    InputError
        If the shape is not supported, its numbers do not fit, or the material is missing.
    """
    general = block.keyword == "BEAM GENERAL SECTION"
    shape = block.text("SECTION").upper() or ("GENERAL" if general else "")
    for word in ("OFFSET1", "OFFSET2"):
        if word in block.parameters and real(block.text(word)) != 0.0:
            raise block.wrong(f"{word} is not supported; move the nodes to the axis of the section")
    sizes = [units.length * x for x in numbers(block, 0)]
    turned, shift = 0.0, 0.0
    try:
        if shape == "GENERAL":
            section, turned = _general(block, units)
        else:
            section, shift = _profile(block, shape, sizes)
        if general:
            material = _own_material(block, materials, units)
        else:
            name = block.text("MATERIAL")
            if name.upper() not in materials:
                raise block.wrong(f"there is no *MATERIAL, NAME={name}; known: {_known(materials)}")
            material = materials[name.upper()]
    except InputError as error:
        if all(problem.where == block.where for problem in error.problems):
            raise
        raise block.wrong(str(error)) from None
    n1 = numbers(block, 1)
    if len(n1) not in (0, 3):
        raise block.wrong(f"its axis n1 has {len(n1)} numbers, must be 3")
    axis = np.array(n1 if n1 and np.any(n1) else DEFAULT_N1)
    return DeckSection(section, material, turn @ axis, turned, shift)


def _known(materials: dict[str, Material]) -> str:
    return ", ".join(sorted(materials)) or "none"


def _own_material(block: Block, materials: dict[str, Material], units: Units) -> Material:
    """Return E and G from the third data line of a general section, and its density."""
    values = numbers(block, 2)
    if len(values) < 2:
        name = block.text("MATERIAL").upper()
        if name in materials:
            return materials[name]
        raise block.wrong("its third data line must be E, G")
    E, G = values[:2]
    if not G > 0.0:
        raise block.wrong(f"G is {G:g}, must be positive")
    rho = real(block.text("DENSITY"))
    return material_of(block.text("ELSET") or "beams", E, 0.5 * E / G - 1.0, rho, units)


def _profile(block: Block, shape: str, s: list[float]) -> tuple[Section, float]:
    """Return a section of a known shape, and the height of its centroid, m."""
    counts = {"RECT": (2,), "CIRC": (1, 2), "PIPE": (2,), "THICK PIPE": (2,), "BOX": (6,)}
    counts |= {"I": (7,)}
    if shape not in counts:
        raise block.wrong(
            f"SECTION={shape or '(none)'} is not supported; use RECT, CIRC, PIPE, BOX or I, or "
            f"give the constants of the section: *BEAM GENERAL SECTION, SECTION=GENERAL"
        )
    if len(s) not in counts[shape]:
        wanted = " or ".join(map(str, counts[shape]))
        raise block.wrong(f"SECTION={shape} has {len(s)} numbers, must be {wanted}")
    if shape == "RECT":
        return Rectangle(s[0], s[1]), 0.0
    if shape == "CIRC":  # Abaqus: the radius; CalculiX: two diameters
        if len(s) == 2 and s[0] != s[1]:
            raise block.wrong("an ellipse is not supported; give its constants, SECTION=GENERAL")
        return Circle(2.0 * s[0] if len(s) == 1 else s[0]), 0.0
    if shape in ("PIPE", "THICK PIPE"):
        return Tube(2.0 * s[0], s[1]), 0.0
    if shape == "BOX":
        width, height, right, top, left, bottom = s
        if right != left or top != bottom:
            raise block.wrong("walls opposite each other differ; give SECTION=GENERAL")
        return Box(width=width, height=height, web=right, flange=top), 0.0
    low, height, b1, b2, t1, t2, web = s
    if b1 != b2 or t1 != t2:
        raise block.wrong("its flanges differ; give its constants, SECTION=GENERAL")
    return IBeam(height=height, width=b1, web=web, flange=t1), 0.5 * height - low


def _general(block: Block, units: Units) -> tuple[Section, float]:
    """Return a section from A, I11, I12, I22 and J, and the angle of its principal axes."""
    values = numbers(block, 0)
    if len(values) < 5:
        raise block.wrong(f"has {len(values)} numbers, must be A, I11, I12, I22, J")
    A = values[0] * units.length**2
    I11, I12, I22, J = (x * units.length**4 for x in values[1:5])
    # int x x^T dA in axes 1, 2 with I12 = int x1 x2 dA; keep the larger moment near its axis
    moments, axes = np.linalg.eigh(np.array([[I22, I12], [I12, I11]]))
    first = int(np.argmax(np.abs(axes[0])))
    e1 = axes[:, first] * np.sign(axes[0, first])
    # Abaqus uses shear coefficients of 1 for sections given by constants
    section = GeneralSection(
        A=A, Iy=float(moments[1 - first]), Iz=float(moments[first]), J=J, ky=1.0, kz=1.0
    )
    return section, float(np.arctan2(e1[1], e1[0]))
