"""Block ``monitor`` of a model file, and the monitor that it describes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import AnyField, Item, Reference, Text, field
from jousto.base.numbers import Duration, Number
from jousto.measurement.monitor.alarms import AlarmLimits
from jousto.measurement.monitor.health import ChannelRules
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.twin.reconstruction import Reconstruction
from jousto.measurement.twin.signals import GaugeErrors, gauge_errors
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.sensors.damage import Correction, Curve, Residue
from jousto.mechanism.sensors.damage_rule import RESIDUES
from jousto.mechanism.sensors.gauge import Gauge
from jousto.recovery.shape import find_body
from jousto.simulation.results.solution import Solution

WIDER = 2.0
"""Factor on the modal coordinates of the reference run in the prior covariance."""

LOOSE = 0.02
"""Share of the prior covariance in which modes are uncorrelated."""


class Gauges(Reference[Iterable[Gauge], "tuple[Gauge, ...]"]):
    """Type of fields: gauges; a model file contains their names."""

    form = "references"
    section = "gauges"
    word = "gauge"
    noun = "sequence of Gauge"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the gauges as a tuple."""
        return problems.several(where, self.name, value, Gauge)


class MonitorSettings(GaugeErrors):
    """Settings to monitor a part by its gauges: stress, damage, remaining life and alarms.

    Raises
    ------
    InputError
        With all inconsistent settings.
    """

    kind = "monitor"
    gauges: Gauges = field(
        "Strain gauges on one flexible body; their names are the column names of the data"
    )
    spots: AnyField = field(
        "Monitored stress sites such as e1.a.top, or the number of hot spots of the reference run",
        form="spots",
        noun="tuple of str, or int",
    )
    separation: Number = field(
        "Smallest distance between hot spots of the reference run", unit="m", default=0.0
    )
    criterion: Text = field("Of the stress", default="signed-von-mises")
    noise: Number = field(
        "Standard deviation of the gauges, including the strain that the modes do not represent",
        unit="m/m",
        above=0,
        wanted="a positive number",
        default=1e-6,
    )
    reference: AnyField = field(
        "Empty for none, run to simulate the model first, or a results file of it: gives the size "
        "of the modal coordinates, so that there may be fewer gauges than modes, and the hot spots",
        form="run",
        noun="str",
        default="",
    )
    sn: Curve = field("S-N curve", default=None)
    mean: Correction = field("Mean stress correction", default=None)
    residue: Residue = field(
        "Rule for cycles open at the end: how they count", words=RESIDUES, default="half"
    )
    limits: Item[AlarmLimits] = field("Limits that raise an alarm", default=AlarmLimits())
    rules: Item[ChannelRules] = field(
        "Rules for invalid values of a channel", key="channels", default=ChannelRules()
    )
    level: Number = field("Confidence level of the bands", default=0.95)
    every: Duration = field("Time between summaries", default=1.0)
    columns: AnyField = field(
        "Column of the data for each gauge; without an entry the column of the same name",
        form="columns",
        noun="mapping of str to str",
        default=None,
    )
    unit: AnyField = field(
        "Unit of columns without a unit, such as um/m", form="text", noun="str", default=None
    )
    together = ("gauges", "reference")

    def consistent(self, problems: Problems, where: str) -> None:
        """Add problems: gauges of several bodies, hot spots without a reference run."""
        gauges = self.gauges
        if not gauges:
            problems.add(where, "no gauges; add sensors of type gauge to the model")
        bodies = {gauge.body.name for gauge in gauges}
        if len(bodies) > 1:
            problems.add(
                where,
                f"gauges are on several bodies ({', '.join(sorted(bodies))}); name those of one "
                "with gauges:",
                "gauges",
            )
        if isinstance(self.spots, int) and not isinstance(self.spots, bool):
            if self.spots < 1:
                problems.add(where, f"spots is {self.spots}, must be 1 or more", "spots")
            if not self.reference:
                problems.add(
                    where,
                    "hot spots are found in a reference run: give reference: run (or a results "
                    "file of the model), or name the spots",
                )

    @property
    def body(self) -> str:
        """Name of the monitored body."""
        return str(self.gauges[0].body.name)

    def monitor(self, run: Solution | None = None) -> Monitor:
        """Return the monitor of these settings.

        Parameters
        ----------
        run : Solution, optional
            Reference run of the same model.

        Raises
        ------
        InputError
            If hot spots or a prior need a run that is missing, or gauges cannot distinguish modes.
        """
        body = self.gauges[0].body
        reduced = body.reduced if isinstance(body, FlexibleBody) else body
        B = np.vstack([gauge.rows for gauge in self.gauges])
        prior = None if run is None else prior_of(run, self.body)
        deviations = {"factor": self.factor, "position": self.position, "angle": self.angle}
        twin = Reconstruction(
            B,
            noise=self.noise,
            prior=prior,
            names=tuple(gauge.name for gauge in self.gauges),
            errors=gauge_errors(self.gauges, **deviations) if any(deviations.values()) else None,
        )
        spots = self.spots
        if isinstance(spots, int):
            if run is None:
                raise InputError(Problem("monitor", "hot spots are found in a reference run"))
            spots = hot_spots_of_run(run, self, spots)
        return Monitor(
            twin,
            reduced,
            spots,
            criterion=self.criterion,
            sn=self.sn,
            mean=self.mean,
            residue=self.residue,
            limits=self.limits,
            rules=self.rules,
            level=self.level,
            every=self.every,
            scale=self.scale,
        )


def prior_of(run: Solution, body: str) -> Array:
    """Return the prior covariance of modal coordinates, about zero, from a run of the model.

    ``G = 4 (0.98 C + 0.02 diag C)`` with ``C = mean(p p^T)``: room for motions twice as large as in
    the run, and for a slightly different correlation of the modes.
    """
    shape = find_body(run, body)
    start = shape.q_offset + 7
    p = run.q[:, start : start + shape.n]
    C = p.T @ p / len(p)
    # modes without motion in the run get a small variance
    floor = 1e-6 * np.max(np.diag(C), initial=1e-300)
    return np.asarray(WIDER**2 * (C + LOOSE * (np.diag(np.diag(C)) - C) + floor * np.eye(len(C))))


def hot_spots_of_run(run: Solution, settings: MonitorSettings, count: int) -> tuple[str, ...]:
    """Return the hot spots of a run, largest stress first."""
    from jousto.recovery.fields.build import stress_field
    from jousto.recovery.hotspots.hot_spots import hot_spots

    body = settings.gauges[0].body
    reduced = body.reduced if isinstance(body, FlexibleBody) else body
    found = hot_spots(
        stress_field(run, settings.body, reduced=reduced),
        count=count,
        criterion=settings.criterion,
        separation=settings.separation,
    )
    return tuple(spot.site for spot in found)
