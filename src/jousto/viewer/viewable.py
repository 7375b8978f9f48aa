"""Objects and files that the viewer can show."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_input
from jousto.fatigue.miner.damage_field import DamageField
from jousto.mesh.formats import MESHES, begins_as_mesh, is_cad, is_mesh
from jousto.reduction.files.suffixes import SID
from jousto.reduction.reduced import ReducedPart
from jousto.schema.file.document import MODELS, is_hdf5
from jousto.schema.output_paths import DAMAGED, REDUCED_PART, RESULTS, hdf5_format
from jousto.schema.read import ModelFile, read_model
from jousto.simulation.results.solution import load
from jousto.viewer.file_watch import check_comparable

if TYPE_CHECKING:
    from jousto.scene.scene import Scene

HDF5 = (".h5", ".hdf5")
SHOWN = (*HDF5, *MODELS)


def scenes_of(
    things: Sequence[Any],
    *,
    damage: DamageField | Sequence[DamageField] | None = None,
    modes: bool = False,
    trust: bool = False,
) -> list[Scene]:
    """Return the scenes of objects and files, the first one first.

    Parameters
    ----------
    things : sequence
        Objects, or paths of results, models, reduced parts and meshes.
    damage : DamageField or sequence of these, optional
        Damage of bodies of the first run.
    modes : bool
        Show the modes of vibration of machines instead of their pose.
    trust : bool
        Whether Python code and mock-up units that model files name may run.

    Raises
    ------
    InputError
        For other files, damage without a run, and objects that cannot be shown.
    """
    from jousto.scene.make import make_scene

    fields = (damage,) if isinstance(damage, DamageField) else tuple(damage or ())
    found = []
    for k, thing in enumerate(things):
        if isinstance(thing, DamageField):
            message = "is coloured on its body: jo.view(run, damage=field)"
            raise InputError(Problem(f"damage of '{thing.body}'", message))
        opened = read(Path(thing), trust=trust) if isinstance(thing, str | Path) else thing
        if isinstance(opened, ModelFile):
            opened = opened.mechanism
        if modes:
            opened = modes_of(opened)
        found.append(make_scene(opened, damage=fields if k == 0 else ()))
    check_comparable(found)
    return found


def read(path: Path, *, trust: bool = False) -> Any:
    """Return the object in a file.

    Raises
    ------
    InputError
        If the file does not exist or cannot be shown.
    """
    suffix = path.suffix.lower()
    if path.is_dir():
        inside = [file.name for file in sorted(path.iterdir()) if file.suffix in SHOWN]
        hint = f", such as {inside[0]}" if inside else ""
        raise InputError(Problem(str(path), f"is a folder; name a file in it{hint}"))
    if not path.is_file():
        raise MissingFileError(Problem(str(path), "no such file"))
    check_input(path)
    kind = hdf5_format(path) if is_hdf5(path) else ""
    if kind == DAMAGED:
        message = "is cut off or damaged: copy it again, or run what has written it again"
        raise InputError(Problem(str(path), message))
    if kind == RESULTS:
        return load(path)
    if kind == REDUCED_PART or suffix in SID:
        return ReducedPart.load(path)
    if not kind and suffix in HDF5 and not is_hdf5(path):
        raise InputError(Problem(str(path), "is not an HDF5 file, in spite of its suffix"))
    if kind or suffix in HDF5:
        message = "contains neither results nor a reduced part"
        raise InputError(Problem(str(path), message))
    if suffix in MODELS:
        return read_model(path, trust=trust)
    from jousto.mesh.readers.files import read_mesh

    if not (is_mesh(path) or is_cad(path) or begins_as_mesh(path) or not path.stat().st_size):
        message = (
            f"cannot be shown; known: results and reduced parts {' '.join(HDF5)}, "
            f"models {' '.join(MODELS)}, meshes {' '.join(MESHES)}"
        )
        raise InputError(Problem(str(path), message))
    return read_mesh(path)


def modes_of(thing: Any) -> Any:
    """Return the modes of vibration of a mechanism or a compiled model about its equilibrium.

    Raises
    ------
    InputError
        If the object is neither of these.
    """
    from jousto.mechanism.mechanism import Mechanism
    from jousto.model.compile import compile
    from jousto.model.model import Model
    from jousto.simulation.modes.linear import modes
    from jousto.simulation.statics.equilibrium import equilibrium

    if isinstance(thing, Mechanism):
        thing = compile(thing)
    if not isinstance(thing, Model):
        if isinstance(thing, ReducedPart):
            return thing  # reduced parts and results of modes are shown with their modes
        raise InputError(Problem("modes", "need a model file: only a machine has them"))
    return modes(thing, equilibrium(thing))
