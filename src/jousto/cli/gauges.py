"""Command ``gauges``: strain gauges, their values, and the comparison with measured ones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import Output, Trust
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution

GAUGE_UNITS = ("m/m", "V/V")


@command()
def gauges(
    file: Annotated[
        Path, typer.Argument(metavar="MODEL|RESULT", help="Model file, or results of a run.")
    ],
    measured: Annotated[
        Path | None,
        typer.Option("--measured", metavar="FILE", help="Record (.csv, .uff, .h5) to compare."),
    ] = None,
    pair: Annotated[
        list[str] | None,
        typer.Option("--pair", metavar="CHANNEL=SENSOR", help="Which belong together."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="CHANNEL=UNIT", help="Unit that the record lacks."),
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate", help="Samples per second of a record without time.")
    ] = None,
    repair: Annotated[
        bool, typer.Option("--repair", help="Sort time that runs backwards, drop doubles.")
    ] = False,
    align: Annotated[
        str, typer.Option("--align", metavar="CHANNEL|no", help="By which channel; the first.")
    ] = "",
    level: Annotated[
        float | None, typer.Option("--level", help="Align by crossings of this value (SI).")
    ] = None,
    max_shift: Annotated[
        float | None, typer.Option("--max-shift", help="Largest shift in time, s.")
    ] = None,
    gauge_factor: Annotated[
        float, typer.Option("--gauge-factor", help="Of channels in mV/V beside strains.")
    ] = 2.0,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write the values over time.")
    ] = None,
    output: Output = None,
    trust: Trust = False,
) -> None:
    """List strain gauges and their values, or compare them with a measured record."""
    from jousto.schema.file.document import is_hdf5

    if not is_hdf5(file):
        if measured is not None or csv is not None or output is not None:
            raise InputError(
                Problem(
                    str(file),
                    "is a model: --measured, --csv and -o need results; run it first, jousto run "
                    f"{file} -o RESULT.h5",
                )
            )
        _list_model(file, trust)
        return
    from jousto.measurement.gauges.compare import compare_gauges
    from jousto.measurement.gauges.read import read_record
    from jousto.measurement.gauges.record import record_of
    from jousto.simulation.results.solution import load

    run = load(file)
    if measured is None:
        names = _list_result(run)
        if output is not None:
            from jousto.output.plot import plot

            plot(run, *names, path=output)
            say(f"picture in {output}")
        if csv is not None:
            record_of(run, names).to_csv(csv)
            say(f"values in {csv}")
        return
    record = read_record(measured, rate=rate, units=_mapping("--unit", unit), repair=repair)
    found = compare_gauges(
        run,
        record,
        pairs=None if pair is None else _mapping("--pair", pair),
        align=False if align == "no" else align or True,
        level=level,
        max_shift=max_shift,
        gauge_factor=gauge_factor,
    )
    say(str(found))
    if csv is not None:
        found.to_csv(csv)
        say(f"values in {csv}")
    if output is not None:
        from jousto.output.plot import plot

        plot(found, path=output)
        say(f"picture in {output}")


def _mapping(option: str, items: list[str] | None) -> dict[str, str]:
    out = {}
    for item in items or ():
        name, sign, value = item.partition("=")
        if not sign or not name or not value:
            raise InputError(Problem(option, f"is '{item}', must be two names such as g1=um/m"))
        out[name] = value
    return out


def _list_model(file: Path, trust: bool) -> None:
    """Print the gauges of a model, and how well they distinguish the modes of their body."""
    import numpy as np

    from jousto.mechanism.sensors.bridge import Bridge
    from jousto.mechanism.sensors.gauge import Gauge, gauge_rows
    from jousto.mechanism.sensors.rosette import Rosette
    from jousto.schema.read import read_model

    mechanism = read_model(file, trust=trust).mechanism
    found: list[Any] = [s for s in mechanism.sensors if isinstance(s, Gauge | Rosette | Bridge)]
    if not found:
        raise InputError(
            Problem(
                str(file), "has no gauges; sensors of type gauge, rosette and bridge measure strain"
            )
        )
    rows = [("", "kind", "body", "position (mm)", "direction", "grid (mm)")]
    for s in found:
        if isinstance(s, Bridge):
            rows.append((s.name, f"{s.kind} bridge", s.body.name, "", "", ""))
            continue
        first = s if isinstance(s, Gauge) else s.grids[0]
        rows.append(
            (
                s.name,
                "gauge" if isinstance(s, Gauge) else f"rosette {s.kind}",
                s.body.name,
                ", ".join(f"{1e3 * x + 0.0:.4g}" for x in s.position.round(9)),
                ", ".join(f"{x + 0.0:.3g}" for x in s.axis.round(6)),
                f"{1e3 * first.length:.3g} x {1e3 * first.width:.3g}" if first.length else "point",
            )
        )
    columns(rows)
    for name in dict.fromkeys(s.body.name for s in found):
        mine = [s for s in found if s.body.name == name and not isinstance(s, Bridge)]
        if not mine:
            continue
        B = gauge_rows(mine)
        values = np.linalg.svd(B, compute_uv=False)
        rank = int(np.count_nonzero(values > 1e-9 * values[0]))
        say(
            f"{name}: {len(B)} grids, {B.shape[1]} modes, rank {rank}"
            + ("" if rank >= B.shape[1] else "; fewer than modes, strain between them is a guess")
        )


def _list_result(run: Solution) -> list[str]:
    """Print the gauges of a run and return their names."""
    import numpy as np

    from jousto.base.units import shown_unit

    names = [name for name in run.sensors if str(run.about(name)["unit"]) in GAUGE_UNITS]
    if not names:
        raise InputError(Problem(run.where, "no gauge among its sensors (nothing in m/m or V/V)"))
    rows = [("", "unit", "smallest", "at (s)", "largest", "at (s)", "")]
    for name in names:
        about, values = run.about(name), np.asarray(run[name])
        values = values.reshape(len(values), -1)
        parts = about["components"] if values.shape[1] > 1 else ("",)
        unit, factor = shown_unit(str(about["unit"]))
        for part, x in zip(parts, values.T, strict=True):
            low, high = int(np.argmin(x)), int(np.argmax(x))
            rows.append(
                (
                    f"{name}.{part}" if part else name,
                    unit,
                    f"{factor * x[low]:.5g}",
                    f"{run.time[low]:.5g}",
                    f"{factor * x[high]:.5g}",
                    f"{run.time[high]:.5g}",
                    str(about["description"]),
                )
            )
    columns(rows)
    return names
