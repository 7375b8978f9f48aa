"""Parts: what a flexible body is made of, before it is reduced."""

from jousto.parts.beam import EulerBernoulli, Theory, Timoshenko
from jousto.parts.cells import Cells
from jousto.parts.curve_library import estimate_sn, sn_curve, sn_curves
from jousto.parts.curves import SN
from jousto.parts.holes import Hole
from jousto.parts.inspection import Finding
from jousto.parts.interface import Interface, Tie
from jousto.parts.library import material, materials
from jousto.parts.loads import NodalForce, Pressure, Spin, SurfaceLoad, Traction, Weight
from jousto.parts.mass import MassPoints, PointMass
from jousto.parts.material import Material
from jousto.parts.mean_stress import (
    FKM,
    SWT,
    Gerber,
    Goodman,
    MeanStress,
    Morrow,
    PartCompression,
    Soderberg,
    Walker,
    WeldRatio,
)
from jousto.parts.members import Member
from jousto.parts.mesh import Mesh
from jousto.parts.orthotropic import Orthotropic
from jousto.parts.part import Part
from jousto.parts.picks import InBox, InCylinder, InSphere, Nearest, Pick
from jousto.parts.profiles import Box, IBeam
from jousto.parts.quality import Quality
from jousto.parts.readers import mesh_step, read_mesh
from jousto.parts.section import (
    Circle,
    GeneralSection,
    Rectangle,
    Section,
    SectionPoint,
    Tube,
    polar_moment,
)
from jousto.parts.section_stress import StressPoint
from jousto.parts.solids import SolidStress
from jousto.parts.solids.error import MeshError, mesh_error, place_errors
from jousto.parts.strength import (
    finish_factor,
    load_factor,
    reliability_factor,
    roughness_factor,
    size_factor,
)
from jousto.parts.stress import StressOperator
from jousto.parts.welds import fat_class, thickness_factor

__all__ = [
    "FKM",
    "SN",
    "SWT",
    "Gerber",
    "Goodman",
    "MeanStress",
    "Morrow",
    "PartCompression",
    "Soderberg",
    "Walker",
    "WeldRatio",
    "estimate_sn",
    "fat_class",
    "finish_factor",
    "load_factor",
    "reliability_factor",
    "roughness_factor",
    "size_factor",
    "sn_curve",
    "sn_curves",
    "thickness_factor",
    "Box",
    "Cells",
    "Circle",
    "EulerBernoulli",
    "Finding",
    "GeneralSection",
    "Hole",
    "IBeam",
    "InBox",
    "InCylinder",
    "InSphere",
    "Interface",
    "MassPoints",
    "Material",
    "Member",
    "Mesh",
    "MeshError",
    "Nearest",
    "Orthotropic",
    "Part",
    "Pick",
    "PointMass",
    "Quality",
    "Rectangle",
    "Section",
    "SectionPoint",
    "StressPoint",
    "SolidStress",
    "StressOperator",
    "Theory",
    "Tie",
    "Timoshenko",
    "Tube",
    "NodalForce",
    "Pressure",
    "Spin",
    "SurfaceLoad",
    "Traction",
    "Weight",
    "material",
    "materials",
    "mesh_error",
    "mesh_step",
    "place_errors",
    "polar_moment",
    "read_mesh",
]
