"""Elements of other programs: corresponding kinds in jousto, and the differences.

Each reader has a table; the page *Meshes and CAD files* contains them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from jousto.mesh.reference import KINDS as SOLIDS


@dataclass(frozen=True)
class ElementType:
    """Kind of jousto into which an element of another program is converted.

    Parameters
    ----------
    kind : str
        Kind of :class:`Cells`.
    formulation : str
        Formulation of the stiffness, see :class:`Cells`.
    replaced : str
        Property of the original element that the element of jousto does not have; empty if there is
        no difference. For shells, beams and trusses, which have no stiffness in a part of solids,
        their description.
    """

    kind: str
    formulation: str = "full"
    replaced: str = ""

    @property
    def solid(self) -> bool:
        """Whether the element has stiffness and mass in a part of solids."""
        return self.kind in SOLIDS

    def because(self, reason: str) -> ElementType:
        """Return the type of an element with one more difference."""
        return replace(self, replaced=f"{self.replaced}, {reason}" if self.replaced else reason)


def _named(
    kind: str, names: str, formulation: str = "full", why: str = ""
) -> dict[str, ElementType]:
    return {name: ElementType(kind, formulation, why) for name in names.split()}


SHELL, BEAM, TRUSS = "a shell", "a beam", "a truss"
PYRAMID = "a pyramid"
_PRESSURE = "its pressure is an unknown of its own"
_HEAT = "made for heat alone"
_PIEZO = "its electric potential is left out"

# ---- Abaqus and CalculiX -------------------------------------------------------------------------

# letters appended to these names without effect on stiffness and mass: T temperature, P pore
# pressure
ABAQUS = (
    _named("tetra", "C3D4")
    | _named("tetra", "C3D4H", why=_PRESSURE)
    | _named("tetra10", "C3D10")
    | _named("tetra10", "C3D10H", why=_PRESSURE)
    | _named("tetra10", "C3D10M C3D10MH C3D10HS C3D10I", why="it is modified against locking")
    | _named("pyramid", "C3D5 C3D5H", why=PYRAMID)
    | _named("wedge", "C3D6", "reduced")
    | _named("wedge", "C3D6H", "reduced", _PRESSURE)
    | _named("wedge15", "C3D15", "reduced")
    | _named("wedge15", "C3D15H", "reduced", _PRESSURE)
    # constant pressure of a compressible material is the mean change of volume
    | _named("hexahedron", "C3D8")
    | _named("hexahedron", "C3D8H", "bbar")
    | _named("hexahedron", "C3D8S C3D8HS", "bbar", "it has better stress at its faces")
    | _named("hexahedron", "C3D8I", "incompatible")
    | _named("hexahedron", "C3D8IH", "incompatible", _PRESSURE)
    | _named("hexahedron", "C3D8R C3D8RH", "reduced")
    | _named("hexahedron20", "C3D20")
    | _named("hexahedron20", "C3D20H", why=_PRESSURE)
    | _named("hexahedron20", "C3D20R", "reduced")
    | _named("hexahedron20", "C3D20RH", "reduced", _PRESSURE)
    | _named("tetra", "DC3D4", why=_HEAT)
    | _named("tetra10", "DC3D10", why=_HEAT)
    | _named("wedge", "DC3D6", why=_HEAT)
    | _named("wedge15", "DC3D15", why=_HEAT)
    | _named("hexahedron", "DC3D8", why=_HEAT)
    | _named("hexahedron20", "DC3D20", why=_HEAT)
    | _named("triangle", "S3 S3R S3RS STRI3 DS3 SC6R", why=SHELL)
    | _named("triangle", "M3D3 CPS3 CPE3 CAX3 SFM3D3 R3D3")
    | _named("triangle6", "STRI65 DS6 S6", why=SHELL)
    | _named("triangle6", "M3D6 CPS6 CPE6 CAX6 SFM3D6")
    | _named("quad", "S4 S4R S4RS S4RSW S4R5 DS4", why=SHELL)
    | _named("quad", "M3D4 M3D4R CPS4 CPS4R CPE4 CPE4R CAX4 CAX4R SFM3D4 SFM3D4R R3D4")
    | _named("quad8", "S8 S8R S8R5 DS8", why=SHELL)
    | _named("quad8", "M3D8 M3D8R CPS8 CPS8R CPE8 CPE8R CAX8 CAX8R SFM3D8 SFM3D8R")
    | _named("line", "B21 B21H B23 B23H B31 B31H B31OS B31OSH B31R B33 B33H", why=BEAM)
    | _named("line", "PIPE21 PIPE21H PIPE31 PIPE31H FRAME2D FRAME3D ELBOW31", why=BEAM)
    | _named("line3", "B22 B22H B32 B32H B32OS B32OSH B32R PIPE22 PIPE32 PIPE32H", why=BEAM)
    | _named("line", "T2D2 T2D2H T3D2 T3D2H", why=TRUSS)
    | _named("line3", "T2D3 T2D3H T3D3 T3D3H", why=TRUSS)
    | _named("line", "R2D2 R3D2 RB3D2 SAX1")
)
# families of names with letters that are not in the table
_FAMILIES = (
    (r"D?C3D(4|5|6|8|10|15|20)(?!\d)", ""),
    (r"(STRI3|STRI65|DS[3468]|S[3468])(?!\d)", SHELL),
    (r"(M3D|CPS|CPE|CAX|SFM3D|R3D)[3468](?!\d)", ""),
    (r"(B|PIPE)[23][123](?!\d)", BEAM),
    (r"T[23]D[23](?!\d)", TRUSS),
)


def abaqus(name: str) -> ElementType | None:
    """Return the kind for an Abaqus or CalculiX element; None if the element is not supported.

    Examples
    --------
    >>> abaqus("C3D8IT").formulation
    'incompatible'
    >>> abaqus("C3D8XYZ").replaced
    'its letters XYZ are not known'
    """
    for text in (name, name.removesuffix("T"), name.removesuffix("P")):
        if text in ABAQUS:
            return ABAQUS[text]
    if name.removesuffix("E") in ABAQUS and name.startswith("C3D"):
        return ABAQUS[name.removesuffix("E")].because(_PIEZO)
    for pattern, _ in _FAMILIES:
        found = re.match(pattern, name)
        if found and found[0] in ABAQUS:
            base = ABAQUS[found[0]]
            letters = f"its letters {name[found.end() :]} are not known"
            return base.because(letters) if base.solid else base
    return None


# ---- Nastran -------------------------------------------------------------------------------------

_BUBBLE = "its bubble functions are close to it, and the same in a cuboid"
# card and number of nodes; PSOLID may select others, see `nastran_solid`
NASTRAN = (
    {
        ("CTETRA", 4): ElementType("tetra"),
        ("CTETRA", 10): ElementType("tetra10"),
        ("CPENTA", 6): ElementType("wedge", "full", "it has bubble functions"),
        ("CPENTA", 15): ElementType("wedge15"),
        ("CHEXA", 8): ElementType("hexahedron", "incompatible", _BUBBLE),
        ("CHEXA", 20): ElementType("hexahedron20"),
        ("CPYRAM", 5): ElementType("pyramid", replaced=PYRAMID),
        ("CPYRAM", 13): ElementType("pyramid13", replaced=PYRAMID),
        ("CPYRA", 5): ElementType("pyramid", replaced=PYRAMID),
        ("CPYRA", 13): ElementType("pyramid13", replaced=PYRAMID),
    }
    | {
        (card, n): ElementType(kind, replaced=SHELL)
        for card, n, kind in (
            ("CTRIA3", 3, "triangle"),
            ("CTRIAR", 3, "triangle"),
            ("CTRIA6", 6, "triangle6"),
            ("CQUAD4", 4, "quad"),
            ("CQUADR", 4, "quad"),
            ("CSHEAR", 4, "quad"),
            ("CQUAD8", 8, "quad8"),
        )
    }
    | {
        (card, 2): ElementType("line", replaced=why)
        for card, why in (
            ("CBAR", BEAM),
            ("CBEAM", BEAM),
            ("CROD", TRUSS),
            ("CTUBE", TRUSS),
            ("CONROD", TRUSS),
        )
    }
)


def nastran_solid(card: str, nodes: int, network: str = "", isop: str = "") -> ElementType:
    """Return the kind for a Nastran solid with the PSOLID fields IN and ISOP.

    ``IN=TWO`` with ``ISOP=FULL`` is the plain isoparametric brick of eight nodes; ``IN=TWO`` means
    2 x 2 x 2 points in the brick of 20 nodes.
    """
    found = NASTRAN[card, nodes]
    two, full = network.upper() in ("TWO", "2"), isop.upper() in ("FULL", "1")
    if (card, nodes) == ("CHEXA", 8) and full:
        return ElementType("hexahedron")
    if (card, nodes) == ("CPENTA", 6) and full:
        return ElementType("wedge")
    if (card, nodes) == ("CHEXA", 20) and two:
        return ElementType("hexahedron20", "reduced")
    return found


# ---- Ansys ---------------------------------------------------------------------------------------

# number of the type and kind of its brick, which may be degenerate; other shapes follow
_ENHANCED = "its enhanced strain has four more unknowns"
_14 = "it is integrated at 14 points"


def ansys_solid(code: int, kind: str, options: Iterable[tuple[int, int]] = ()) -> ElementType:
    """Return the kind for a solid of Ansys.

    Parameters
    ----------
    code : int
        Number of the type, such as 185.
    kind : str
        Kind of cell with the shape of the element: bricks of Ansys may be wedges, pyramids or
        tetrahedra.
    options : iterable of (int, int)
        KEYOPTs, number and value; 0 if missing.
    """
    option = dict(options)
    if kind.startswith("pyramid"):
        return ElementType(kind, replaced=PYRAMID)
    if kind == "hexahedron":
        technology = option.get(2, 0)
        if code == 185:
            how = ("bbar", "reduced", "incompatible", "incompatible")[min(technology, 3)]
            return ElementType(kind, how, _ENHANCED if technology == 2 else "")
        if technology == 1:
            return ElementType(kind, "reduced")
        return ElementType(kind, "full" if option.get(1, 0) == 1 else "incompatible")
    if kind == "hexahedron20":
        if (code, option.get(2, 0)) == (186, 0) or (code, option.get(11, 0)) == (95, 1):
            return ElementType(kind, "reduced")
        return ElementType(kind, replaced=_14)
    if kind == "wedge15":
        return ElementType(kind, "reduced")
    if code == 285:
        return ElementType(kind, replaced=_PRESSURE)
    return ElementType(kind)


ANSYS_BRICKS = {45: 8, 64: 8, 65: 8, 185: 8, 95: 20, 186: 20}
ANSYS_TETRAHEDRA = {92: 10, 187: 10, 285: 4}
ANSYS_SHELLS = (43, 63, 93, 181, 281)
ANSYS_FACES = (152, 154)  # surface elements that carry loads
ANSYS_LINES = {4: BEAM, 44: BEAM, 188: BEAM, 189: BEAM, 8: TRUSS, 180: TRUSS}


def ansys_name(code: int) -> str:
    """Return the name of a type, such as SOLID185."""
    if code in ANSYS_BRICKS or code in ANSYS_TETRAHEDRA:
        return f"SOLID{code}"
    if code in ANSYS_LINES:
        return f"{'LINK' if ANSYS_LINES[code] == TRUSS else 'BEAM'}{code}"
    return f"SHELL{code}"


def ansys(code: int, kind: str, options: Mapping[int, int]) -> ElementType:
    """Return the kind for an element of Ansys, see `ansys_solid`."""
    if code in ANSYS_SHELLS:
        return ElementType(kind, replaced=SHELL)
    if code in ANSYS_FACES:
        return ElementType(kind)
    if code in ANSYS_LINES:
        return ElementType(kind, replaced=ANSYS_LINES[code])
    return ansys_solid(code, kind, options.items())
