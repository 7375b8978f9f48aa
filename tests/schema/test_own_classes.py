"""A body or a sensor of one's own: one class, which the rest of the package knows by its fields."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
import pytest

import jousto as jo
from jousto.base.declare import SECTIONS
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.bodies.body import Shaped
from jousto.mechanism.bodies.marker import MarkerField
from jousto.mechanism.bodies.shapes import Solid, cylinder
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.signals.base import USE, Signal
from jousto.mechanism.signals.piecewise import polynomials
from jousto.schema.read import model_schema, parse_model

TEXT = """\
bodies:
  - {type: hub, name: rotor, bore: 100 mm, outer: 20 cm, width: 5 cm, density: 7.85 g/cm3,
     markers: {rim: [20 cm, 0, 0]}, velocity: [0, 0, 3 m/s]}
gravity: [0, 0, -9.81]
sensors:
  - {type: climb, name: up, marker: rotor.rim, from_height: -25 cm}
simulation: {t_end: 0.5 s}
"""


@pytest.fixture(autouse=True)
def classes() -> Iterator[tuple[type, type]]:
    """Declare the classes, and forget them afterwards."""

    class Hub(Shaped, tag="hub"):
        """A homogeneous disc with a bore, about z."""

        bore: Number = field("Inner radius", unit="m", least=0)
        outer: Number = field("Outer radius", unit="m", above=0)
        width: Number = field("Along the axis", unit="m", above=0)

        @property
        def solid(self) -> Solid:
            full, hole = (
                cylinder(r, self.width, np.array([0.0, 0.0, 1.0])) for r in (self.outer, self.bore)
            )
            inertia = full.inertia - hole.inertia
            return Solid(full.volume - hole.volume, full.center, inertia, full.triangles)

    class Climb(Sensor, tag="climb"):
        """Way of a marker from a height, (3,) m."""

        unit: ClassVar[str] = "m"
        frame: ClassVar[str] = "world"
        components: ClassVar[tuple[str, ...]] = ("x", "y", "z")
        marker: MarkerField = field("What climbs")
        from_height: Number = field("Where it begins", unit="m", default=0.0)

        @property
        def description(self) -> str:
            return f"way of {self.marker.label}"

        @property
        def reading(self) -> Reading:
            return Reading("position", self.marker, jo.ground.at((0, 0, self.from_height)))

    yield Hub, Climb
    del SECTIONS["bodies"]["hub"], SECTIONS["sensors"]["climb"]


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_a_model_file_knows_a_body_and_a_sensor_that_were_declared_here():
    file = parse_model(TEXT)
    (rotor,) = file.mechanism.bodies
    assert type(rotor) is jo.RigidBody
    r, R, h = 0.1, 0.2, 0.05
    assert rotor.mass == pytest.approx(7850 * np.pi * h * (R**2 - r**2), rel=1e-14)
    # m (R^2 + r^2) / 2 about the axis, m (3 (R^2 + r^2) + h^2) / 12 across
    across = (3 * (R**2 + r**2) + h**2) / 12
    moments = rotor.mass * np.array([across, across, (R**2 + r**2) / 2])
    assert np.diag(rotor.inertia) == pytest.approx(moments, rel=1e-13)
    run = jo.simulate(jo.compile(file.mechanism), file.simulation.t_end)
    # v t - g t^2 / 2 from the start, 25 cm above the height; RK4 is exact but for round-off
    assert run["up"][-1] == pytest.approx([0.2, 0, 0.25 + 1.5 - 9.81 / 8], abs=1e-12)


def test_they_have_entries_help_and_checks(classes):
    hub, climb = classes
    entry = model_schema()["$defs"]["HubEntry"]
    assert {"bore", "outer", "width", "mass", "density", "markers", "position"} < set(
        entry["properties"]
    )
    assert set(entry["required"]) == {"type", "name", "bore", "outer", "width"}
    assert "bore : float\n    Inner radius, m." in hub.__doc__
    text = TEXT.replace("bore: 100 mm", "bore: 100 kg").replace("from_height", "height")
    with pytest.raises(jo.InputError) as error:
        parse_model(text, name="m.yaml")
    first, second = map(str, error.value.problems)
    assert first.startswith("m.yaml:2: bodies.0.bore: expects a length (m), got 100 kg")
    assert second.startswith("m.yaml:6: sensors.0.height: unknown key 'height'")
    with pytest.raises(jo.InputError, match="body 'h': outer is 0 m, must be positive"):
        hub("h", 0.0, 0.0, 1.0, mass=1.0)
    other = jo.RigidBody("other", 1.0, (1.0, 1.0, 1.0))
    body = jo.RigidBody("body", 1.0, (1.0, 1.0, 1.0))
    with pytest.raises(jo.InputError, match="marker: body 'other' is not in the mechanism"):
        jo.Mechanism(body, climb("up", other["origin"]))


def test_a_model_file_drives_a_slide_by_a_signal_that_was_declared_here():
    class Dwell(Signal, tag="dwell"):
        """A move of a height in a time, at rest at both ends: ``3 s^2 - 2 s^3``."""

        height: Number = field("Height", unit=USE)
        duration: Number = field("Time", unit="s", above=0)

        def jet(self, t):
            s = np.clip(t / self.duration, 0.0, 1.0)
            h, T = self.height, self.duration
            inside = (t >= 0) & (t < T)
            return (
                h * s**2 * (3 - 2 * s),
                6 * h / T * s * (1 - s),
                np.where(inside, 6 * h / T**2 * (1 - 2 * s), 0.0),
            )

        @property
        def law(self):
            h, T = self.height, self.duration
            return polynomials(
                np.array([0.0, T]), np.array([[-2 * h / T**3], [3 * h / T**2], [0], [0]])
            )

    text = """\
bodies: [{name: cam, mass: 2 kg, inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: lift, a: ground.origin, b: cam.origin, axis: [0, 0, 1]}]
couplings:
  - type: drive
    name: drive
    coordinate: lift.displacement
    signal: {type: dwell, height: 20 mm, duration: 0.5 s}
sensors:
  - {type: coordinate, name: z, coordinate: lift.displacement}
  - {type: reaction, name: push, joint: drive}
"""
    try:
        run = jo.simulate(jo.compile(parse_model(text).mechanism), 0.5, solver=jo.RK4(0.01))
    finally:
        del SECTIONS["signals"]["dwell"]
    t, h, T = run.time, 0.02, 0.5
    assert run["z"][:, 0] == pytest.approx(h * (t / T) ** 2 * (3 - 2 * t / T), abs=1e-12)
    force = 2.0 * 6 * h / T**2 * (1 - 2 * t / T)
    assert np.abs(run["push"][1:-1, 0]) == pytest.approx(np.abs(force[1:-1]), abs=1e-9)
