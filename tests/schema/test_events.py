"""Events and switched signals in the model file."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.signals.switched import Switched
from jousto.schema.read import parse_model

TEXT = """\
name: crane
bodies:
  - {name: boom, mass: 200, inertia: [10, 200, 200], center: [2, 0, 0]}
joints:
  - {name: slewing, type: revolute, a: ground.origin, b: boom.origin, axis: [0, 0, 1]}
forces:
  - name: motor
    type: joint-force
    coordinate: slewing.angle
    signal:
      type: sum
      terms:
        - type: switched
          event: limit switch
          before: 2 kN m
          after: {type: constant, value: -100}
        - 0
sensors:
  - {name: tip, type: velocity, marker: {body: boom, at: [4, 0, 0]}}
  - {name: torque, type: force, force: motor}
events:
  - {name: limit switch, watch: slewing.angle, threshold: 60 deg, direction: rising}
  - {name: fast, watch: tip, component: y, threshold: 5 m/s}
  - {name: end, watch: slewing.angle, threshold: 1 rev, stop: true}
  - {name: reversed, watch: torque, direction: falling}
simulation: {t_end: 20 s, output_step: 0.1 s, solver: {type: RK4, step: 10 ms}}
"""


def test_events_equal_the_python_constructors():
    mechanism = parse_model(TEXT).mechanism
    slewing, motor = mechanism.joints[0], mechanism.forces[0]
    limit, fast, end, back = mechanism.events
    assert limit.watch.same_as(slewing.angle)
    assert limit.threshold == pytest.approx(1.0471975511965976)
    assert (limit.direction, limit.stop, end.stop) == ("rising", False, True)
    assert fast.watch is mechanism.sensors[0]
    assert (fast.component, fast.threshold) == (1, 5.0)
    assert back.watch is mechanism.sensors[1]
    assert end.threshold == pytest.approx(6.283185307179586)
    switched = motor.signal.parts[0]
    assert isinstance(switched, Switched)
    assert switched.event is limit
    assert switched.before(0.0) == 2000.0
    assert [s.name for s in mechanism.sensors] == ["tip", "torque"]


def test_an_event_names_what_it_releases():
    text = TEXT.replace("direction: falling}", "direction: falling, releases: [motor, slewing]}")
    mechanism = parse_model(text).mechanism
    assert mechanism.events[-1].releases == (mechanism.forces[0], mechanism.joints[0])
    with pytest.raises(jo.InputError, match=r"releases.*no joint, coupling or force 'motr'.*motor"):
        parse_model(text.replace("[motor,", "[motr,"))


def test_the_file_runs_and_stops_at_the_event():
    file = parse_model(TEXT)
    run = jo.simulate(jo.compile(file.mechanism), file.simulation.t_end, **file.simulation.given())
    times = {event.name: event.time for event in run.events}
    # 1000 kg m2: 2 rad/s2 for a sixth of a turn, then -0.1 rad/s2
    limit = np.sqrt(np.pi / 3.0)
    assert times["limit switch"] == times["reversed"] == pytest.approx(limit, abs=1e-10)
    speed = 2.0 * limit
    rest = (speed - np.sqrt(speed**2 - 0.2 * (5.0 / 3.0) * np.pi)) / 0.1
    assert run.time[-1] == times["end"] == pytest.approx(limit + rest, abs=1e-9)
    assert run.attributes["ended"].startswith("stopped by event 'end' at ")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("watch: tip", "watch: tipp", "events.1.watch: no sensor 'tipp'; did you mean 'tip'?"),
        ("component: y", "component: w", "events.1: sensor 'tip' has no component 'w'"),
        ("component: y, ", "", "events.1: sensor 'tip' has 3 components, name one: x, y, z"),
        ("5 m/s", "5 m", "events.1.threshold: "),
        ("60 deg", "60 m", "events.0.threshold: "),
        ("watch: slewing.angle, threshold: 60", "watch: slewing.angel, threshold: 60",
         "events.0.watch: joint 'slewing' has no angel; did you mean 'angle'?"),
        ("event: limit switch", "event: limt switch",
         "event: no event 'limt switch'; did you mean 'limit switch'?"),
        ("event: limit switch", "event: reversed",
         "event 'reversed' watches a force, a coupling or a signal and cannot switch one"),
        ("direction: rising", "direction: up", "events.0.direction: "),
    ],
)  # fmt: skip
def test_a_mistake_has_its_field_and_remedy(old, new, sentence):
    with pytest.raises(jo.InputError) as error:
        parse_model(TEXT.replace(old, new, 1))
    assert any(sentence in str(problem) for problem in error.value.problems), str(error.value)


def test_an_event_that_watches_a_force_switches_another_one():
    """Names are looked up when they are needed, in any order of the file."""
    brake = """\
  - name: brake
    type: joint-force
    coordinate: slewing.angle
    signal: {type: switched, event: reversed, before: 0, after: -50}
sensors:"""
    mechanism = parse_model(TEXT.replace("sensors:", brake, 1)).mechanism
    event = mechanism.forces[1].signal.event
    assert event is mechanism.events[3]
    assert event.watch.force is mechanism.forces[0]
    assert [force.name for force in mechanism.forces[:2]] == ["motor", "brake"]


def test_what_stands_on_itself_is_reported():
    counted = (
        "  - {name: d, type: damage, sensor: d, residue: half, sn: {S_D: 71 MPa, N_D: 2e6, k: 3}}\n"
    )
    with pytest.raises(jo.InputError, match=r"sensors\.2: 'd' depends on itself"):
        parse_model(TEXT.replace("events:\n", f"{counted}events:\n"))
