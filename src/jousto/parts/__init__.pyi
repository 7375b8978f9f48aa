# names of jo.parts; they are loaded from here when they are first used
from .frames.element import EulerBernoulli as EulerBernoulli, Timoshenko as Timoshenko
from .loads import (
    NodalForce as NodalForce,
    Pressure as Pressure,
    Spin as Spin,
    SurfaceLoad as SurfaceLoad,
    Traction as Traction,
    Weight as Weight,
)
from .mass import PointMass as PointMass
from .matrices.matrices import Matrices as Matrices
from .matrices.read import read_matrices as read_matrices
from .mesh_error import (
    MeshError as MeshError,
    mesh_error as mesh_error,
    place_errors as place_errors,
)
