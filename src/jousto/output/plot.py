"""Function `plot`: the picture of a result, chosen by its type."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem
from jousto.output.dispatch import call, find_entry
from jousto.output.style import Picture

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from jousto.design.identification.identified import Identified
    from jousto.design.optimisation.comparison import Comparison
    from jousto.design.optimisation.optimum import Optimum
    from jousto.design.reliability.form import FormResult
    from jousto.design.reliability.sampling import LinearisationCheck, SamplingResult
    from jousto.design.reliability.targets.rbdo import RbdoResult
    from jousto.design.studies.table import StudyTable
    from jousto.fatigue.cycles.rainflow import Cycles
    from jousto.fatigue.local.strain_life import Rule
    from jousto.fatigue.miner.damage_field import DamageField
    from jousto.fatigue.random.random_response import RandomResponse
    from jousto.materials.strength.mean_stress import MeanStress
    from jousto.materials.strength.sn import SN
    from jousto.materials.strength.strain_life import StrainLife
    from jousto.measurement.gauges.compare import GaugeComparison
    from jousto.measurement.monitor.record_reader import MonitorRecord
    from jousto.measurement.twin.bands.bands import Band
    from jousto.output.scenes.view import View
    from jousto.planar.results import PlanarPath, PlanarRun
    from jousto.recovery.beams.forces import SectionForces
    from jousto.recovery.fields.criteria import Criterion
    from jousto.recovery.fields.field import StressField
    from jousto.recovery.friction import FrictionStress
    from jousto.recovery.hotspots.hot_spots import HotSpots
    from jousto.simulation.modes.campbell import Campbell
    from jousto.simulation.modes.linear import MechanismModes
    from jousto.simulation.results.solution import Solution
    from jousto.simulation.statics.load_path_result import LoadPath

File = str | Path | None

DRAWN = {
    "Solution": "figures.histories.plot_run",
    "StressField": "figures.stress.plot_stress",
    "HotSpots": "figures.hotspots.plot_hotspots",
    "DamageField": "figures.damage.plot_damage",
    "SectionForces": "figures.beams.plot_section_forces",
    "FrictionStress": "figures.stress.plot_friction_stress",
    "SN": "figures.cycles.plot_sn",
    "Cycles": "figures.cycles.plot_cycles",
    "StrainLife": "figures.cycles.plot_hysteresis",
    "RandomResponse": "figures.cycles.plot_spectrum",
    "Campbell": "figures.campbell.plot_campbell",
    "MechanismModes": "figures.modes.plot_modes",
    "LoadPath": "figures.load_path.plot_load_path",
    "GaugeComparison": "figures.measurements.plot_gauges",
    "Band": "figures.measurements.plot_band",
    "MonitorRecord": "figures.measurements.plot_monitor",
    "FormResult": "figures.reliability.plot_form",
    "SamplingResult": "figures.reliability.plot_sampling",
    "LinearisationCheck": "figures.reliability.plot_linearisation",
    "RbdoResult": "figures.reliability.plot_rbdo",
    "PlanarRun": "figures.planar.plot_planar",
    "PlanarPath": "figures.planar.plot_planar",
    "Optimum": "figures.optimisation.plot_optimum",
    "Comparison": "figures.optimisation.plot_comparison",
    "Identified": "figures.identification.plot_identified",
    "StudyTable": "figures.studies.plot_study",
}
BEAM = "figures.beams.plot_beam"


# fmt: off
@overload
def plot(thing: Solution, *, beam: str | Sequence[str], times: ArrayLike | None = ..., view: View | str | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: Solution | Mapping[str, Solution], *names: str, path: File = ...) -> Picture: ...
@overload
def plot(thing: StressField, *, criterion: Criterion = ..., path: File = ...) -> Picture: ...
@overload
def plot(thing: HotSpots, run: Solution, *, view: View | str | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: DamageField, run: Solution, *, quantity: str = ..., view: View | str | None = ..., marks: int = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: SectionForces, *, components: Sequence[str] | str | None = ..., times: ArrayLike | None = ..., at: float | str | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: FrictionStress, *, site: str | None = ..., path: File = ...) -> Picture: ...
@overload
def plot(thing: SN | Sequence[SN], cycles: Cycles | None = ..., *, mean: MeanStress | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: Cycles, sn: SN | None = ..., *, mean: MeanStress | None = ..., bins: int = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: StrainLife, series: ArrayLike, *, rule: Rule = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: RandomResponse, sites: Sequence[str] | str, *, criterion: str = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: Campbell, *, kind: Literal["frequencies", "root locus"] = ..., orders: Sequence[float] = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: MechanismModes, mode: int = ..., *, scale: float = ..., view: View | str | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: LoadPath, sensor: str, *, path: File = ...) -> Picture: ...
@overload
def plot(thing: Band, *, sites: Sequence[str] | str | None = ..., truth: ArrayLike | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: FormResult | SamplingResult | LinearisationCheck | RbdoResult, *, path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: StudyTable, *names: str, kind: Literal["lines", "scatter", "surface", "parallel"] | None = ..., path: File = ...) -> Picture: ...  # noqa: E501
@overload
def plot(thing: GaugeComparison | Identified | MonitorRecord | Optimum | Comparison | PlanarRun | PlanarPath, *, path: File = ...) -> Picture: ...  # noqa: E501
# fmt: on
@explained
def plot(thing: Any, *what: Any, path: File = None, **options: Any) -> Picture:
    """Draw a result; its type determines the picture.

    Parameters
    ----------
    thing : object
        ========================  ============================================================
        thing                     what is drawn, and further arguments
        ========================  ============================================================
        run, or {label: run}      sensors over time: ``"tip.y", "energy", "residuals"``;
                                  shapes of a beam: ``beam="cable"``, `times`, `view`
        stress field              history of a `criterion` at its places
        hot spots                 places and histories; the run, `view`
        damage field              damage over a body; the run, `quantity`, `view`, `marks`
        section forces            along a beam or over time: `components`, `times`, `at`
        friction stress           stress with and without friction at a `site`
        S-N curve, or several     curves; cycles, `mean`
        cycles                    rainflow matrix and levels; an S-N curve, `mean`, `bins`
        strain-life curve         loops at a notch; a history of elastic stress, `rule`
        random response           spectra at places; sites, `criterion`
        Campbell data             frequencies with `orders`, or ``kind="root locus"``
        modes of a machine        the machine in a mode over its shape at rest: the mode from 0,
                                  `scale`, `view`
        load path                 load over a sensor's value; the sensor
        gauge comparison          measured and virtual channels
        identification            measured and fitted channels, residuals
        band of a twin            stress with its band: `sites`, `truth`
        record of a monitor       stress, damage and health of channels
        result of FORM            importance of the variables, sensitivities of beta
        sampled probability       convergence, or the levels of a subset simulation
        linearisation check       indices by FORM beside sampled ones
        reliable design           cost over the cycles, indices beside their targets
        planar run or path        shapes with energies or load factors
        optimum                   cost, largest ratio and parameters over the cycles
        comparison                the same of several methods over the runs
        table of a study          outcomes over parameters: columns, ``kind="lines"``, "scatter",
                                  "surface" or "parallel"
        ========================  ============================================================
    *what
        Arguments that the table names without quotes, in that order.
    path : path, optional
        File to write; the suffix chooses the format: png, svg, pdf, jpg, webp or eps.
    **options
        Arguments that the table names in quotes.

    Returns
    -------
    matplotlib.figure.Figure
        The figure is not registered in pyplot and need not be closed.

    Raises
    ------
    InputError
        For a thing that cannot be drawn, unknown names with suggestions, an unknown suffix or an
        unwritable path.

    Examples
    --------
    ``plot(run, "middle.y", "energy", path="pendulum.png")``, ``plot(damage, run, view="xz")``
    """
    if isinstance(thing, list | tuple):
        if any(type(one).__name__ == "Solution" for one in thing):
            some = ", ".join(f"'run {k + 1}': ..." for k in range(len(thing)))
            text = f"several runs need a label each: jo.plot({{{some}}}, ...)"
            raise InputError(Problem("plot", text))
        kind = "SN"
        place = DRAWN[kind]
    elif type(thing).__name__ not in DRAWN and isinstance(thing, Mapping):
        kind = "Solution"
        place = DRAWN[kind]
    else:
        kind, place = find_entry(DRAWN, thing, "plot")
    place = BEAM if kind == "Solution" and "beam" in options else place
    picture: Picture = call(place, f"plot of a {kind}", thing, *what, path=path, **options)
    return picture
