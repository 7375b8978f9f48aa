"""Losses of the sensors of a machine with a simpler body."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from jousto.base.arrays import Array
from jousto.design.flexibility.body_advice import ReadingAdvice
from jousto.design.flexibility.comparison import Comparison, common, reading_scale
from jousto.design.flexibility.expected import AROUND, Expected, jump
from jousto.design.flexibility.reading_loss import reading_loss
from jousto.design.flexibility.variant_runs import Reading, sensor_readings
from jousto.model.model import SensorModel


def sensor_losses(comparison: Comparison) -> Iterator[ReadingAdvice]:
    """Yield the losses of all sensors.

    Sensors of the deformation of a body that is rigid have the reading of its static deformation.
    """
    simple = {one.name: one for one in sensor_readings(comparison.simple)}
    if comparison.full is None:
        readings = [*simple.values(), *_elastic_readings(comparison.expected, set(simple))]
    else:
        readings = list(sensor_readings(comparison.full))
    for one in readings:
        if comparison.is_wanted(one.name, one.sensor):
            found = _loss(comparison, one, simple.get(one.name))
            if found is not None:
                yield found


def _elastic_readings(expected: Expected | None, known: set[str]) -> Iterator[Reading]:
    """Yield the readings that the rigid machine does not have, with the static deformation."""
    for sensor in () if expected is None else expected.full.sensors:
        if sensor.kind == "damage":
            continue
        units = sensor.unit.split(", ")
        for k, name in enumerate(sensor.components):
            label = sensor.name if sensor.count == 1 else f"{sensor.name}.{name}"
            if label not in known and expected is not None:
                values = expected.static[:, sensor.offset + k]
                unit = units[k * len(units) // sensor.count]
                yield Reading(label, sensor.name, k, unit, 0.0, values)


def _loss(comparison: Comparison, one: Reading, other: Reading | None) -> ReadingAdvice | None:
    """Return the loss of a reading; None if the simpler machine has no such reading."""
    expected, measured, scale = comparison.expected, None, reading_scale(one.values, one.floor)
    sensor = _sensor(expected, one.sensor)
    if other is None and (expected is None or sensor is None):
        return None
    estimate = _estimate(comparison, sensor, one, other)
    if comparison.full is not None:
        if other is not None:
            time, values = comparison.simple.run.time, other.values
        else:
            assert expected is not None and sensor is not None
            time, values = expected.held.time, expected.static[:, sensor.offset + one.component]
        t, y, r = common(comparison.full.run.time, one.values, time, values)
        measured, scale = reading_loss(t, y, r, floor=one.floor), reading_scale(y, one.floor)
    return ReadingAdvice(
        *(one.name, one.unit, measured, estimate, scale),
        recovered=other is None,
        floor=one.floor,
    )


def _sensor(expected: Expected | None, name: str) -> SensorModel | None:
    """Return a sensor of the full machine of an estimate."""
    sensors = () if expected is None else expected.full.sensors
    return next((sensor for sensor in sensors if sensor.name == name), None)


def _estimate(
    comparison: Comparison, sensor: SensorModel | None, one: Reading, other: Reading | None
) -> float:
    """Return the upper figure of the difference of a reading; NaN without an estimate."""
    expected = comparison.expected
    if expected is None or sensor is None:
        return float("nan")
    base: Array = expected.static[:, sensor.offset + one.component]
    if other is not None:
        base = np.interp(expected.held.time, comparison.simple.run.time, other.values)
    known = base[:AROUND] if other is None else other.values
    found = expected.difference(sensor, one.component, base, jump(known, one.unit))
    return found if found > one.floor else 0.0
