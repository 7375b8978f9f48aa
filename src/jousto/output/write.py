"""Function `write`: files for other programs, chosen by type and suffix."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from jousto.base.arguments import explained
from jousto.mesh.formats import WRITTEN as MESH_FORMATS
from jousto.output.dispatch import call, find_entry
from jousto.output.style import target

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from jousto.certificate.certificate import Certificate
    from jousto.design.identification.identified import Identified
    from jousto.design.optimisation.comparison import Comparison
    from jousto.design.optimisation.optimum import Optimum
    from jousto.export.ports import Named
    from jousto.fatigue.miner.damage_field import DamageField
    from jousto.measurement.monitor.monitor import Monitor
    from jousto.mesh.mesh import Mesh
    from jousto.model.model import Model
    from jousto.natural.verification import Verification
    from jousto.parts.part import Part
    from jousto.recovery.fields.criteria import Criterion
    from jousto.recovery.fields.field import StressField
    from jousto.recovery.hotspots.hot_spots import HotSpots
    from jousto.recovery.loads.body_loads import BodyLoads
    from jousto.reduction.reduced import ReducedPart
    from jousto.simulation.results.dataframes import Names
    from jousto.simulation.results.solution import Solution
    from jousto.simulation.solvers.base import Solver
    from jousto.simulation.state import State
    from jousto.simulation.statics.load_path_result import LoadPath

File = str | Path

SID, CONTOUR, BODIES, PROGRAM, TWIN = (
    "files.sid.write_sid",
    "files.contour.write_contour",
    "figures.bodies_series.write_run",
    "files.programs.write_program",
    "files.programs.write_twin",
)
WRITTEN = {
    "Solution": {"csv": "files.table.write_csv", "vtu": BODIES, "pvd": BODIES},
    "StressField": {"csv": "figures.stress.write_stress", "vtu": CONTOUR, "pvd": CONTOUR},
    "HotSpots": {"vtu": "figures.hotspots.write_hotspots"},
    "DamageField": {"vtu": "figures.damage.write_damage"},
    "BodyLoads": dict.fromkeys(("inp", "bdf", "nas"), "files.fe_deck.write_deck"),
    "LoadPath": {"csv": "figures.load_path.write_load_path"},
    "Model": {
        "c": PROGRAM,
        "zip": PROGRAM,
        "fmu": "files.programs.write_fmu",
        "html": "jousto.viewer.wasm_page.write_running",
    },
    "Monitor": {"c": TWIN, "zip": TWIN},
    "Mesh": dict.fromkeys(MESH_FORMATS, "files.meshes.write_mesh"),
    "ReducedPart": {
        "fem": "files.mbdyn.write_fem",
        "sid": SID,
        "sid_fem": SID,
        "vtu": "files.vtu.write_vtu",
    },
    "Certificate": {"html": "pages.certificate.write_certificate"},
    "Verification": {"html": "pages.verification.write_verification"},
    "Optimum": {"html": "pages.optimum.write_optimum"},
    "Comparison": {"html": "pages.optimum.write_optimum"},
    "Identified": {"html": "pages.identification.write_identified"},
}

OWN = {"csv": "to_csv", "h5": "save"}
"""Methods of results that write a format themselves."""


# fmt: off
@overload
def write(thing: Solution, path: File, *, beam: str | None = ..., times: ArrayLike | None = ..., scale: float = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: Solution, path: File, *names: Names, sensors: Names = ...) -> Path: ...
@overload
def write(thing: StressField, path: File, *, criterion: Criterion = ..., time: float | None = ..., histories: bool = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: StressField, path: File, run: Solution, *, criterion: Criterion = ..., times: ArrayLike | None = ..., scale: float = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: HotSpots | DamageField, path: File, run: Solution) -> Path: ...
@overload
def write(thing: BodyLoads, path: File, *, times: Sequence[float] | None = ...) -> Path: ...
@overload
def write(thing: BodyLoads, path: File, part: Part, *, times: Sequence[float] | None = ..., program: Literal["calculix", "abaqus", "nastran"] | None = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: Mesh, path: File, *, unit: str = ...) -> Path: ...
@overload
def write(thing: ReducedPart, path: File, *, nodes: Sequence[str | int] | None = ..., damping: float | Sequence[float] = ..., invariants: bool = ..., stress: bool = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: Model, path: File, *, solver: Solver | None = ..., state: State | None = ..., name: str = ..., version: int = ..., on: Iterable[str] = ..., stop: float = ..., documents: dict[str, bytes] | None = ..., derivatives: bool = ..., named: Sequence[Named] = ..., ranges: Mapping[str, tuple[float, float]] | None = ...) -> Path: ...  # noqa: E501
@overload
def write(thing: Monitor, path: File, *, name: str = ...) -> Path: ...
@overload
def write(thing: LoadPath | Certificate | Verification | Optimum | Comparison | Identified, path: File) -> Path: ...  # noqa: E501
# fmt: on
@explained
def write(thing: Any, path: File, *what: Any, **options: Any) -> Path:
    """Write a mesh, a part or a result for other programs; the suffix determines the format.

    Parameters
    ----------
    thing : object
        ================  ==================  ======================================================
        thing             suffix              what is written, and further arguments
        ================  ==================  ======================================================
        mesh              .vtu .vtk .inp      cells and sets; `unit` of length
                          .msh .med .bdf
                          .nas .stl
        reduced part      .vtu                modes and their `stress` for ParaView
                          .fem                MBDyn: `nodes`, `damping`, `invariants`
                          .sid .SID_FEM       standard input data: `nodes`, `damping`
        certificate       .html               a page without network or script
        verification      .html               a page without network or script
        optimum,          .html               a page without network or script
        comparison,
        identification
        run               .csv                sensors; their names
                          .vtu .pvd           all bodies at `times`, modal deformation times
                                              `scale`; or the surface of one `beam`
        stress field      .csv                envelope of a `criterion`, at a `time`, `histories`
                          .vtu .pvd           over the body; the run, `criterion`, `times`, `scale`
        hot spots         .vtu                worst values and ranks; the run
        damage field      .vtu                damage, life and safety; the run
        loads on a body   .csv                all loads; `times`
                          .inp .bdf .nas      CalculiX, Abaqus, Nastran: the part with its loads as
                                              load steps; the part, `times`, `program`
        load path         .csv                loads, stability and sensors
        compiled model    .c .zip             a program of C99: `solver`, `state`, `name`,
                                              `named` constants
                          .fmu                the same and `version` (2, 3), platforms `on`, `stop`,
                                              further `documents` by their place in it,
                                              directional `derivatives`
                          .html               a page in which it runs: `solver`, `state`, `ranges`
                                              of inputs
        monitor           .c .zip             its twin as a program of C99: `name`
        ================  ==================  ======================================================
    path : path
    *what
        Arguments that the table names without quotes.
    **options
        Arguments that the table names in quotes.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For a thing that cannot be written, an unknown suffix or an unwritable path.

    Examples
    --------
    ``write(reduced, "arm.fem", damping=0.01)``, ``write(field, "arm.pvd", run, scale=10)``
    """
    kind, formats = find_entry(WRITTEN, thing, "write")
    suffix = Path(path).suffix.lower().lstrip(".")
    if suffix not in formats:
        own = OWN.get(suffix, "")
        hint = f"; its method {own}(path) writes .{suffix}" if hasattr(thing, own) else ""
        target(path, tuple(formats), hint=hint)
    done: Path = call(formats[suffix], f".{suffix} of a {kind}", thing, path, *what, **options)
    return done
